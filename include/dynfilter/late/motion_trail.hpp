// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <dynfilter/correspondence/match.hpp>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <vector>

namespace dynfilter {

/// Motion of one feature since the previous frame. Distorted pixels; depths [m], NaN: no depth.
struct MotionSample {
  cv::Point2f from_px, to_px;
  float from_depth_m, to_depth_m;
};

/// What the trail keeps of a frame: the motion that leads to it from the previous frame.
struct TrailFrame {
  std::int64_t id = -1, from_id = -1;  ///< from_id -1: no motion leads to this frame
  std::vector<MotionSample> samples;
  cv::Size image_px;
  /// CV_32FC1, every 4th pixel of the depth image; NaN: no depth; empty: no depth image.
  cv::Mat depth_m;
};

/// Frame-to-frame motion of the features of recent frames.
/// Late results are carried along it although no image is kept.
/// Half a second of it takes less memory than one image pyramid.
class MotionTrail {
 public:
  static constexpr int kCellPx = 4;
  static constexpr std::size_t kFrames = 64;

  /// Adds a frame: the pixels and depths [m] of its features, their match to an earlier frame
  /// and its depth image as thin_depth() makes it.
  /// Takes over the memory of `thin_depth_m` and returns other memory in exchange.
  void add(std::int64_t id, const Match& match, const std::vector<cv::Point2f>& px,
           const std::vector<float>& depths_m, cv::Mat& thin_depth_m, cv::Size image_px);

  /// The cell that contains this pixel position.
  /// Positions far outside any image and NaN give a cell far outside, too.
  static cv::Point cell_of(const cv::Point2f& px);

  /// Every 4th pixel of a depth image. See TrailFrame.
  /// Only CV_32FC1 and CV_16UC1 are read; other types give an empty image.
  static void thin_depth(const cv::Mat& depth, double unit_m, cv::Mat& out);

  static void fill_samples(const Match& match, const std::vector<cv::Point2f>& px,
                           const std::vector<float>& depths_m, std::vector<MotionSample>& samples);

  const TrailFrame* find(std::int64_t id) const;

  /// Lists the frames from one to another in order, without the first.
  /// False if the trail does not connect them.
  bool path(std::int64_t from_id, std::int64_t to_id, std::vector<const TrailFrame*>& out) const;

  void reset() { size_ = begin_ = 0; }

 private:
  TrailFrame& next();

  template <class T>
  static void thin(const cv::Mat& depth, float unit_m, cv::Mat& out);

  std::vector<TrailFrame> frames_;  ///< ring buffer
  std::size_t begin_ = 0, size_ = 0;
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/late/detail/motion_trail-inl.hpp>
#endif
