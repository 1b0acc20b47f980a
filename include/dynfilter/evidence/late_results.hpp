// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <dynfilter/core/detection.hpp>
#include <dynfilter/evidence/current_frame.hpp>
#include <dynfilter/evidence/frame_matches.hpp>
#include <dynfilter/late/carried_box.hpp>
#include <dynfilter/late/late_semantics.hpp>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <vector>

namespace dynfilter {

/// Boxes and masks of older frames, carried to the current one. Records the motion that they are carried
/// along, once results have come late.
class LateResults {
 public:
  LateResults(CurrentFrame& current, FrameMatches& matches) : current_(current), matches_(matches) {}

  /// True if a stage reads boxes or masks. Otherwise nothing is recorded.
  void set_used(bool used) { used_ = used; }

  /// `first_call`: this is the first call point of the frame.
  void begin(bool first_call);
  void end() {
    if (used_ && may_come_late()) record_step();
  }
  void reset() { carrier_.reset(); }

  const std::vector<Detection>* boxes(int max_age_frames);
  const cv::Mat* labels();

 private:
  /// The k-th mask of `carried_`.
  const cv::Mat& instance(const CarriedBox& box, cv::Size image_px, std::size_t k);
  /// Records the motion since the last frame, once per frame.
  void record_step();
  /// This frame's subsampled depth image. The motion history takes over its memory.
  cv::Mat& sparse_depth();
  bool is_late() const;
  /// False while results arrive on time: the motion history is not needed.
  /// Before the first late result, the motion history must not cause extra flow.
  bool may_come_late() const;

  CurrentFrame& current_;
  FrameMatches& matches_;
  LateSemantics carrier_;
  std::vector<Detection> carried_;
  std::vector<cv::Mat> instances_;  ///< memory of their masks
  cv::Mat sparse_depth_m_;
  bool used_ = false, seen_ = false, sparse_depth_ready_ = false;
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/evidence/detail/late_results-inl.hpp>
#endif
