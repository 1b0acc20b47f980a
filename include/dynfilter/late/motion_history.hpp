// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <dynfilter/correspondence/match.hpp>
#include <dynfilter/geometry/depth_sampler.hpp>
#include <limits>
#include <opencv2/core.hpp>
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

/// Frame-to-frame motion of the features of recent frames. Late results are carried along it although no
/// image is kept. Half a second of it takes less memory than one image pyramid.
class MotionHistory {
 public:
  static constexpr int kCellPx = 4;
  static constexpr std::size_t kFrames = 64;

  /// Adds a frame: the pixels and depths [m] of its features, their match to an earlier frame and its depth
  /// image as sparse_depth() makes it.
  /// Takes over the memory of `sparse_depth_m` and returns other memory in exchange.
  void add(std::int64_t id, const Match& match, const std::vector<cv::Point2f>& px,
           const std::vector<float>& depths_m, cv::Mat& sparse_depth_m, cv::Size image_px);

  /// The cell that contains this pixel position.
  /// Positions far outside any image and NaN give a cell far outside, too.
  static cv::Point cell_of(const cv::Point2f& px);

  /// Every 4th pixel of a depth image. See MotionFrame.
  /// Only CV_32FC1 and CV_16UC1 are read; other types give an empty image.
  static void sparse_depth(const cv::Mat& depth, double unit_m, cv::Mat& out);

  /// Moves and depths of the matches, for frame_motion().
  static void fill_samples(const Match& match, const std::vector<cv::Point2f>& px,
                           const std::vector<float>& depths_m, std::vector<MotionSample>& samples);

  /// Null: the frame is not kept.
  const MotionFrame* find(std::int64_t id) const {
    for (std::size_t k = 0; k < size_; ++k)
      if (frames_[(begin_ + k) % kFrames].id == id) return &frames_[(begin_ + k) % kFrames];
    return nullptr;
  }

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

inline void MotionHistory::add(std::int64_t id, const Match& match, const std::vector<cv::Point2f>& px,
                               const std::vector<float>& depths_m, cv::Mat& sparse_depth_m,
                               cv::Size image_px) {
  MotionFrame& frame = next();
  frame.id = id;
  frame.from_id = match.reference != nullptr ? match.reference->id : -1;
  frame.image_px = image_px;
  fill_samples(match, px, depths_m, frame.samples);
  cv::swap(frame.depth_m, sparse_depth_m);
}

inline cv::Point MotionHistory::cell_of(const cv::Point2f& px) {
  // Other values do not fit an int.
  constexpr float kMost = 1e8F;
  const auto cell = [](float at) {
    return at > -kMost && at < kMost ? cvFloor(at / static_cast<float>(kCellPx)) : -static_cast<int>(kMost);
  };
  return {cell(px.x), cell(px.y)};
}

inline void MotionHistory::sparse_depth(const cv::Mat& depth, double unit_m, cv::Mat& out) {
  if (depth.type() == CV_16UC1)
    sample_depth<std::uint16_t>(depth, static_cast<float>(unit_m), out);
  else if (depth.type() == CV_32FC1)
    sample_depth<float>(depth, static_cast<float>(unit_m), out);
  else
    out.release();
}

inline void MotionHistory::fill_samples(const Match& match, const std::vector<cv::Point2f>& px,
                                        const std::vector<float>& depths_m,
                                        std::vector<MotionSample>& samples) {
  samples.clear();
  for (std::size_t i = 0; match.reference != nullptr && i < px.size(); ++i)
    if (match.found(i))
      samples.push_back(
          {match.correspondences.reference_px[i], px[i], match.reference_depth_m[i], depths_m[i]});
}

inline bool MotionHistory::path(std::int64_t from_id, std::int64_t to_id,
                                std::vector<const MotionFrame*>& out) const {
  out.clear();
  while (to_id > from_id) {
    const MotionFrame* frame = find(to_id);
    if (frame == nullptr || frame->from_id >= to_id) return false;
    out.push_back(frame);
    to_id = frame->from_id;
  }
  std::reverse(out.begin(), out.end());
  return to_id == from_id;
}

inline MotionFrame& MotionHistory::next() {
  if (frames_.empty()) frames_.resize(kFrames);
  if (size_ < kFrames) return frames_[(begin_ + size_++) % kFrames];
  MotionFrame& oldest = frames_[begin_];
  begin_ = (begin_ + 1) % kFrames;
  return oldest;
}

template <class T>
void MotionHistory::sample_depth(const cv::Mat& depth, float unit_m, cv::Mat& out) {
  out.create((depth.rows + kCellPx - 1) / kCellPx, (depth.cols + kCellPx - 1) / kCellPx, CV_32FC1);
  const auto row = [&](int r) { return depth.ptr<T>(std::min(r * kCellPx + kCellPx / 2, depth.rows - 1)); };
  constexpr int kLine = 64 / sizeof(T), kMiddle = kCellPx / 2;
  for (int r = 0; r < out.rows; ++r) {
    const T *from = row(r), *next = row(r + 1);
    // The image is not in the cache, and three of four rows are skipped.
    // Hardware prefetching therefore does not help.
    for (int c = 0; c < depth.cols; c += kLine) __builtin_prefetch(next + c);
    float* __restrict to = out.ptr<float>(r);
    // Cells whose middle is inside the image.
    const int whole = (depth.cols + kMiddle - 1) / kCellPx;
    for (int c = 0; c < whole; ++c) to[c] = static_cast<float>(from[c * kCellPx + kMiddle]) * unit_m;
    if (whole < out.cols) to[whole] = static_cast<float>(from[depth.cols - 1]) * unit_m;
    constexpr float kMost_m = std::numeric_limits<float>::max();  // as valid_depth(), without a branch
    for (int c = 0; c < out.cols; ++c)
      to[c] = ((to[c] > 0) & (to[c] <= kMost_m)) ? to[c] : DepthSampler::kNone;
  }
}

}  // namespace dynfilter
