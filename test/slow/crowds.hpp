// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/frame_view.hpp>
#include <functional>
#include <limits>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

/// Frames that are built to take long: many features, arranged so that everything is near everything.
namespace crowds {

constexpr int kWidth_px = 640, kHeight_px = 480;
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

/// Which of the inputs that lead to correspondences the frames have.
enum class Source { Flow, Descriptors, Host };

/// A frame that owns what its view points to.
struct Crowd {
  std::int64_t id = 0;
  std::vector<cv::KeyPoint> keypoints;
  cv::Mat descriptors, grey, depth, labels;
  std::vector<float> depth_m;
  std::vector<std::int64_t> map_point_ids;
  std::vector<cv::Point3f> map_points;
  std::vector<std::int32_t> match_index;
  std::vector<dynfilter::Detection> boxes;
  std::vector<dynfilter::KeyframeView> keyframes;
  std::vector<cv::KeyPoint> undistorted;
  dynfilter::Camera camera;

  dynfilter::FrameView view();
};

/// Pseudo-random numbers that the standard does not leave open.
class Random {
 public:
  explicit Random(std::uint32_t seed) : state_(seed * 2654435761U + 1) {}
  std::uint32_t bits() {
    state_ = state_ * 1664525U + 1013904223U;
    return state_ >> 8U;
  }
  float within(float low, float high) {
    return low + (high - low) * static_cast<float>(bits()) / static_cast<float>(1U << 24U);
  }

 private:
  std::uint32_t state_;
};

/// How n features are arranged. `change` makes the k-th frame of `crowd`, which is uniform and without boxes.
struct Arrangement {
  std::string name;
  Source source = Source::Flow;
  std::function<void(Crowd& crowd, int k)> change;
};

/// All arrangements. Every one is tried with every pipeline.
std::vector<Arrangement> arrangements();

/// The k-th frame of n features. Equal arguments, equal frames.
Crowd crowd(const Arrangement& arrangement, std::size_t n, int k);

}  // namespace crowds
