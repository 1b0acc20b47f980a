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

  /// The next frame: its features' pixels and depths [m], their match to an earlier frame, its depth image as
  /// thin_depth() leaves it (its memory is taken, and other memory given back).
  void add(std::int64_t id, const Match& match, const std::vector<cv::Point2f>& px,
           const std::vector<float>& depths_m, cv::Mat& thin_depth_m, cv::Size image_px) {
    TrailFrame& frame = next();
    frame.id = id;
    frame.from_id = match.reference != nullptr ? match.reference->id : -1;
    frame.image_px = image_px;
    fill_samples(match, px, depths_m, frame.samples);
    cv::swap(frame.depth_m, thin_depth_m);
  }

  /// Every 4th pixel of a depth image (CV_32FC1 or CV_16UC1; anything else: none), see TrailFrame.
  static void thin_depth(const cv::Mat& depth, double unit_m, cv::Mat& out) {
    if (depth.type() == CV_16UC1)
      thin<std::uint16_t>(depth, static_cast<float>(unit_m), out);
    else if (depth.type() == CV_32FC1)
      thin<float>(depth, static_cast<float>(unit_m), out);
    else
      out.release();
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

  template <class T>
  static void thin(const cv::Mat& depth, float unit_m, cv::Mat& out) {
    out.create((depth.rows + kCellPx - 1) / kCellPx, (depth.cols + kCellPx - 1) / kCellPx, CV_32FC1);
    const auto row = [&](int r) { return depth.ptr<T>(std::min(r * kCellPx + kCellPx / 2, depth.rows - 1)); };
    constexpr int kLine = 64 / sizeof(T), kMiddle = kCellPx / 2;
    for (int r = 0; r < out.rows; ++r) {
      const T *from = row(r), *next = row(r + 1);
      // The image is not in the cache, and three of four rows are left out: nothing else fetches ahead.
      for (int c = 0; c < depth.cols; c += kLine) __builtin_prefetch(next + c);
      float* __restrict to = out.ptr<float>(r);
      const int whole = (depth.cols + kMiddle - 1) / kCellPx;  // whose middle lies in the image
      for (int c = 0; c < whole; ++c) to[c] = static_cast<float>(from[c * kCellPx + kMiddle]) * unit_m;
      if (whole < out.cols) to[whole] = static_cast<float>(from[depth.cols - 1]) * unit_m;
      for (int c = 0; c < out.cols; ++c) to[c] = valid_depth(to[c]) ? to[c] : DepthSampler::kNone;
    }
  }

  std::vector<TrailFrame> frames_;  ///< a ring
  std::size_t begin_ = 0, size_ = 0;
};

}  // namespace dynfilter
