// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/semantic/runner.hpp>
#include <opencv2/core/mat.hpp>
#include <utility>

namespace dynfilter {

/// Boxes and masks of one camera stream: those that the host sets, else those of a file or a detector.
class HostSemantics {
 public:
  /// Null: only what is set.
  explicit HostSemantics(std::unique_ptr<SemanticRunner> runner = nullptr) : runner_(std::move(runner)) {}

  /// For the next frame. `frame_id`: the frame they were computed on, -1: the next one.
  /// Masks are copied unless the detections are the only reference to them.
  void set_detections(std::vector<Detection> detections, std::int64_t frame_id);
  void set_mask(const cv::Mat& labels, std::int64_t frame_id);  ///< copied

  /// A new frame. Its pixels are copied where a detector needs them later.
  void begin(const SemanticImage& image);

  void add_to(FrameView& view) const;  ///< what there is for the frame begun last

  void reset();  ///< frame numbers start again: what was computed on earlier ones is dropped

  std::string take_error();  ///< the first error of the file or the detector, once; "" without one

 private:
  struct Given {
    std::optional<std::vector<Detection>> detections;
    std::int64_t detections_frame_id = -1;
    bool has_mask = false;  ///< false: `mask` only keeps its memory
    MaskInput mask;

    void clear() { detections.reset(), has_mask = false; }
  };

  std::unique_ptr<SemanticRunner> runner_;
  Given now_, next_;
  SemanticRunner::Result result_;
  bool told_ = false;
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/hosts/detail/host_semantics-inl.hpp>
#endif
