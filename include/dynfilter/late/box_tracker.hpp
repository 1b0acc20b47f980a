// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <dynfilter/core/detection.hpp>
#include <dynfilter/core/span.hpp>
#include <dynfilter/late/carried_box.hpp>
#include <dynfilter/late/motion_history.hpp>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <tuple>
#include <vector>

namespace dynfilter {

/// Tracks boxes over several results of the detector.
/// A new result and the old boxes are carried to the same frame.
/// Boxes of one class are paired by overlap, largest overlap first. A pair continues one track.
/// The detector may miss an object.
/// An unpaired old box is therefore kept for up to 30 frames if two results contained it.
/// Instance masks are copied once for each result: about 0.02 ms for 640 x 480. Their memory is reused.
class BoxTracker {
 public:
  static constexpr double kMinOverlap = 0.3;  // intersection over union
  static constexpr int kMaxBridged = 30;      // frames since the box was detected

  const std::vector<CarriedBox>& boxes() const { return boxes_; }

  /// Moves all boxes to the next frame.
  void carry(const MotionFrame& to);

  /// Adds the boxes of a newer result, detected on frame `found_id`.
  /// They are carried along `path` to the frame of the old boxes.
  void take(Span<const Detection> detections, std::int64_t found_id,
            const std::vector<const MotionFrame*>& path);

  void reset() {
    boxes_.clear();
    spare_masks_.clear();
  }

 private:
  static double overlap(const cv::Rect2f& a, const cv::Rect2f& b);

  /// Replaces the host's mask by a copy.
  void own_mask(cv::Mat& mask);
  void recycle_mask(CarriedBox& box);

  /// Pairs new boxes with old ones. Paired old boxes are removed from boxes_.
  void pair_up();

  BoxCarrier carrier_;
  std::vector<CarriedBox> boxes_, new_;
  std::vector<cv::Mat> spare_masks_;  ///< memory of masks whose boxes are gone
  std::vector<std::tuple<double, std::size_t, std::size_t>> pairs_;
  std::vector<std::uint8_t> paired_new_, paired_old_;
  int next_id_ = 0;
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/late/detail/box_tracker-inl.hpp>
#endif
