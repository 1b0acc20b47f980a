// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstdint>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/span.hpp>
#include <opencv2/core.hpp>
#include <vector>

namespace dynfilter {

struct DepthGrowthParams {
  double max_step_share = 0.015;  ///< of the depth: a larger step from pixel to pixel is a jump
  double max_reach_m = 0.5;       ///< in 3-D from the seed that a pixel was grown from; 0: no limit
};

/// Grows seeds over a depth image, stopping at depth jumps: from the features of a moving object to its
/// pixels, for the map (Zhou et al. sec. 3.2.2) and for masks (DynaSLAM's region growing, without its limits
/// on the reach). What touches the object without a jump, the floor under feet, is reached too: max_reach_m
/// bounds that. Cost: linear in the pixels that are grown; clearing the mask is linear in the image. Nothing
/// is allocated from the second image of a size on.
class DepthGrowth {
 public:
  explicit DepthGrowth(const DepthGrowthParams& params = DepthGrowthParams()) : params_(params) {}

  /// `depth`: CV_32FC1 or CV_16UC1 of `unit_m` metres, anything else grows nothing; `seeds_px` in its pixels.
  /// Seeds outside the image or without depth are left out. `mask` becomes CV_8UC1 of the same size, 255
  /// where grown. Without a valid camera the reach is not limited; distortion is neglected.
  /// `rivals_px` are seeds of what surrounds the object, such as static features: all seeds grow at the same
  /// pace, and a pixel belongs to the one that is there first. So the floor under feet goes to the floor.
  void grow(const cv::Mat& depth, double unit_m, const Camera& camera, Span<const cv::Point2f> seeds_px,
            cv::Mat& mask, Span<const cv::Point2f> rivals_px = {}) {
    mask.create(depth.size(), CV_8UC1);
    mask.setTo(0);
    if (depth.empty()) return;
    camera_ = camera;
    unit_m_ = static_cast<float>(unit_m);
    if (depth.type() == CV_32FC1)
      run<float>(depth, seeds_px, rivals_px, mask);
    else if (depth.type() == CV_16UC1)
      run<std::uint16_t>(depth, seeds_px, rivals_px, mask);
    if (!rivals_px.empty()) mask.setTo(0, mask == kRival);
  }

 private:
  static constexpr std::uint8_t kGrown = 255, kRival = 1;
  struct Pixel {
    int x, y;
    cv::Point3f seed_m;
    std::uint8_t label;
  };

  template <class T>
  float depth_m(const cv::Mat& depth, int x, int y) const {
    return static_cast<float>(depth.at<T>(y, x)) * unit_m_;
  }
  cv::Point3f point_m(int x, int y, float z) const {
    if (!camera_.valid()) return {0, 0, 0};
    return {
        (static_cast<float>(x) - static_cast<float>(camera_.cx_px)) / static_cast<float>(camera_.fx_px) * z,
        (static_cast<float>(y) - static_cast<float>(camera_.cy_px)) / static_cast<float>(camera_.fy_px) * z,
        z};
  }

  template <class T>
  void run(const cv::Mat& depth, Span<const cv::Point2f> seeds_px, Span<const cv::Point2f> rivals_px,
           cv::Mat& mask) {
    open_.clear();
    add_seeds<T>(depth, seeds_px, kGrown, mask);
    add_seeds<T>(depth, rivals_px, kRival, mask);
    // First in, first out: a pixel belongs to about the nearest seed.
    std::size_t next = 0;
    while (next < open_.size()) spread<T>(depth, open_[next++], mask);
  }
  template <class T>
  void add_seeds(const cv::Mat& depth, Span<const cv::Point2f> seeds_px, std::uint8_t label, cv::Mat& mask) {
    for (const cv::Point2f& seed : seeds_px) {
      if (!(seed.x > -0.5F && seed.y > -0.5F && seed.x < 32767 && seed.y < 32767)) continue;
      const int x = cvRound(seed.x), y = cvRound(seed.y);
      if (x >= depth.cols || y >= depth.rows || mask.at<std::uint8_t>(y, x) != 0) continue;
      const float z = depth_m<T>(depth, x, y);
      if (!(z > 0 && std::isfinite(z))) continue;
      mask.at<std::uint8_t>(y, x) = label;
      open_.push_back({x, y, point_m(x, y, z), label});
    }
  }

  template <class T>
  void spread(const cv::Mat& depth, const Pixel from, cv::Mat& mask) {
    constexpr int kSteps[4][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};
    const float z = depth_m<T>(depth, from.x, from.y);
    const float max_step_m = static_cast<float>(params_.max_step_share) * z;
    for (const auto& [dx, dy] : kSteps) {
      const int x = from.x + dx, y = from.y + dy;
      if (x < 0 || y < 0 || x >= depth.cols || y >= depth.rows || mask.at<std::uint8_t>(y, x) != 0) continue;
      const float there = depth_m<T>(depth, x, y);
      if (!(there > 0 && std::abs(there - z) <= max_step_m) || !in_reach(from.seed_m, x, y, there)) continue;
      mask.at<std::uint8_t>(y, x) = from.label;
      open_.push_back({x, y, from.seed_m, from.label});
    }
  }
  bool in_reach(const cv::Point3f& seed_m, int x, int y, float z) const {
    if (params_.max_reach_m <= 0 || !camera_.valid()) return true;
    return cv::norm(point_m(x, y, z) - seed_m) <= params_.max_reach_m;
  }

  DepthGrowthParams params_;
  Camera camera_;
  float unit_m_ = 1;
  std::vector<Pixel> open_;
};

}  // namespace dynfilter
