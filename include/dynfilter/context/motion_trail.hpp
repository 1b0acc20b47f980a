// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <dynfilter/context/depth_sampler.hpp>
#include <dynfilter/context/match.hpp>
#include <opencv2/core.hpp>
#include <vector>

namespace dynfilter {

/// Where a feature of one frame was in the frame before. Distorted pixels; depths [m], NaN: none.
struct MotionSample {
  cv::Point2f from_px, to_px;
  float from_depth_m, to_depth_m;
};

/// What is kept of a frame to carry things to it from the frame before.
struct TrailFrame {
  std::int64_t id = -1, from_id = -1;  ///< from_id -1: nothing leads here
  std::vector<MotionSample> samples;
  cv::Size image_px;
  cv::Mat depth_m;  ///< CV_32FC1, every 4th pixel of the depth image, NaN: none; empty: no depth image
};

/// The motion of the last frames' features, frame to frame: sparse, so that half a second costs less memory
/// than one image pyramid. What is late can be carried from frame to frame although no image is kept.
class MotionTrail {
 public:
  static constexpr int kCellPx = 4;
  static constexpr std::size_t kFrames = 64;

  /// The next frame: its features' pixels and depths [m], their match to an earlier frame, its depth image.
  void add(std::int64_t id, const Match& match, const std::vector<cv::Point2f>& px,
           const std::vector<float>& depths_m, const cv::Mat& depth, double depth_unit_m, cv::Size image_px) {
    TrailFrame& frame = next();
    frame.id = id;
    frame.from_id = match.reference != nullptr ? match.reference->id : -1;
    frame.image_px = image_px;
    fill_samples(match, px, depths_m, frame.samples);
    fill_depth(depth, depth_unit_m, frame.depth_m);
  }

  static void fill_samples(const Match& match, const std::vector<cv::Point2f>& px,
                           const std::vector<float>& depths_m, std::vector<MotionSample>& samples) {
    samples.clear();
    for (std::size_t i = 0; match.reference != nullptr && i < px.size(); ++i)
      if (match.found(i))
        samples.push_back(
            {match.correspondences.reference_px[i], px[i], match.reference_depth_m[i], depths_m[i]});
  }

  const TrailFrame* find(std::int64_t id) const {
    for (std::size_t k = 0; k < size_; ++k)
      if (frames_[(begin_ + k) % kFrames].id == id) return &frames_[(begin_ + k) % kFrames];
    return nullptr;
  }

  /// The frames that lead from one to another, in order, without the first. False where the trail does not.
  bool path(std::int64_t from_id, std::int64_t to_id, std::vector<const TrailFrame*>& out) const {
    out.clear();
    while (to_id > from_id) {
      const TrailFrame* frame = find(to_id);
      if (frame == nullptr || frame->from_id >= to_id) return false;
      out.push_back(frame);
      to_id = frame->from_id;
    }
    std::reverse(out.begin(), out.end());
    return to_id == from_id;
  }

  void reset() { size_ = begin_ = 0; }

 private:
  TrailFrame& next() {
    if (frames_.empty()) frames_.resize(kFrames);
    if (size_ < kFrames) return frames_[(begin_ + size_++) % kFrames];
    TrailFrame& oldest = frames_[begin_];
    begin_ = (begin_ + 1) % kFrames;
    return oldest;
  }

  static void fill_depth(const cv::Mat& depth, double unit_m, cv::Mat& out) {
    if (depth.type() != CV_32FC1 && depth.type() != CV_16UC1) return out.release();
    out.create((depth.rows + kCellPx - 1) / kCellPx, (depth.cols + kCellPx - 1) / kCellPx, CV_32FC1);
    for (int r = 0; r < out.rows; ++r) {
      const int y = std::min(r * kCellPx + kCellPx / 2, depth.rows - 1);
      float* to = out.ptr<float>(r);
      for (int c = 0; c < out.cols; ++c) {
        const int x = std::min(c * kCellPx + kCellPx / 2, depth.cols - 1);
        const float z = (depth.type() == CV_16UC1 ? static_cast<float>(depth.at<std::uint16_t>(y, x))
                                                  : depth.at<float>(y, x)) *
                        static_cast<float>(unit_m);
        to[c] = valid_depth(z) ? z : DepthSampler::kNone;
      }
    }
  }

  std::vector<TrailFrame> frames_;  ///< a ring
  std::size_t begin_ = 0, size_ = 0;
};

}  // namespace dynfilter
