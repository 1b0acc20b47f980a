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

/// What the motion history keeps of a frame: the motion that leads to it from the previous frame.
struct MotionFrame {
  std::int64_t id = -1, from_id = -1;  ///< from_id -1: no motion leads to this frame
  std::vector<MotionSample> samples;
  cv::Size image_px;
  /// CV_32FC1, every 4th pixel of the depth image; NaN: no depth; empty: no depth image.
  cv::Mat depth_m;
};

/// Frame-to-frame motion of the features of recent frames.
/// Late results are carried along it although no image is kept.
/// Half a second of it takes less memory than one image pyramid.
class MotionHistory {
 public:
  static constexpr int kCellPx = 4;
  static constexpr std::size_t kFrames = 64;

  /// Adds a frame: the pixels and depths [m] of its features, their match to an earlier frame
  /// and its depth image as sparse_depth() makes it.
  /// Takes over the memory of `sparse_depth_m` and returns other memory in exchange.
  void add(std::int64_t id, const Match& match, const std::vector<cv::Point2f>& px,
           const std::vector<float>& depths_m, cv::Mat& sparse_depth_m, cv::Size image_px);

  /// The cell that contains this pixel position.
  /// Positions far outside any image and NaN give a cell far outside, too.
  static cv::Point cell_of(const cv::Point2f& px);

  /// Every 4th pixel of a depth image. See MotionFrame.
  /// Only CV_32FC1 and CV_16UC1 are read; other types give an empty image.
  static void sparse_depth(const cv::Mat& depth, double unit_m, cv::Mat& out);

  static void fill_samples(const Match& match, const std::vector<cv::Point2f>& px,
                           const std::vector<float>& depths_m, std::vector<MotionSample>& samples);

  const MotionFrame* find(std::int64_t id) const;

  /// Lists the frames from one to another in order, without the first.
  /// False if the motion history does not connect them.
  bool path(std::int64_t from_id, std::int64_t to_id, std::vector<const MotionFrame*>& out) const;

  void reset() { size_ = begin_ = 0; }

 private:
  MotionFrame& next();

  template <class T>
  static void sample_depth(const cv::Mat& depth, float unit_m, cv::Mat& out);

  std::vector<MotionFrame> frames_;  ///< ring buffer
  std::size_t begin_ = 0, size_ = 0;
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/late/detail/motion_history-inl.hpp>
#endif
