// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <dynfilter/core/error.hpp>
#include <dynfilter/config/field_table.hpp>
#include <dynfilter/core/span.hpp>
#include <dynfilter/correspondence/correspondences.hpp>
#include <dynfilter/correspondence/flow_params.hpp>
#include <dynfilter/correspondence/guided_flow.hpp>
#include <dynfilter/correspondence/image_pyramid.hpp>
#include <dynfilter/correspondence/lucas_kanade.hpp>
#include <dynfilter/correspondence/patch_residual.hpp>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <vector>

namespace dynfilter {

/// Pyramidal Lucas-Kanade flow (Bouguet 2000)
/// from the current frame's features back to a reference frame.
/// Results are the same for any number of threads. Buffers are reused from call to call.
class FlowTracker {
 public:
  /// Throws ConfigError for parameters out of range.
  /// Own and OpenCv use OpenCV's threads, Guided at most `threads` of them.
  explicit FlowTracker(const FlowParams& params = FlowParams(), int threads = 1)
      : params_(checked(params)), guided_(params_, threads), patches_(params_.window_px) {}
  const FlowParams& params() const { return params_; }

  /// Builds the pyramid of an image with this tracker's settings.
  void build(const cv::Mat& grey, ImagePyramid& pyramid) const {
    pyramid.build(grey, params_.window_px, params_.levels, !(guided() || own()));
  }

  /// `current_px` are distorted pixels.
  /// `guess` is the expected position of each point in the reference frame, NaN if unknown.
  /// An empty `guess` means no motion.
  /// Points that are NaN, outside the image or fail the check are not found.
  /// Images of different size find nothing.
  /// Cost: see docs/explanation/correspondence.md.
  void track(const ImagePyramid& current, const ImagePyramid& reference, Span<const cv::Point2f> current_px,
             Span<const cv::Point2f> guess, Correspondences& out) {
    track(current, reference, current_px, guess, params_.check, out);
  }

  /// Tracks over a large gap. Follows the points through `steps`:
  /// the frames before the current one, newest first, ending with the reference.
  /// Then tracks each point directly between both ends, with the end of the chain as guess,
  /// so that drift does not accumulate. Only this last step is checked.
  /// Cost: one unchecked track() per step and one checked track().
  void track_chain(const ImagePyramid& current, Span<const ImagePyramid* const> steps,
                   Span<const cv::Point2f> current_px, Correspondences& out);

 private:
  using Points = std::vector<cv::Point2f>;

  static const FlowParams& checked(const FlowParams& params);

  void track(const ImagePyramid& current, const ImagePyramid& reference, Span<const cv::Point2f> current_px,
             Span<const cv::Point2f> guess, FlowCheck check, Correspondences& out);

  void collect(const cv::Size& size, Span<const cv::Point2f> current_px, Span<const cv::Point2f> guess);

  bool guided() const {
    return params_.engine == FlowEngine::Guided && GuidedFlow::supports(params_.window_px);
  }
  bool own() const {
    return params_.engine != FlowEngine::OpenCv && LucasKanade::supports(params_.window_px);
  }

  void lucas_kanade(const ImagePyramid& a, const ImagePyramid& b, const Points& from, Points& to);

  void keep_inside(const cv::Size& size);

  void check_each(const ImagePyramid& current, const ImagePyramid& reference, FlowCheck check);

  void keep_alike(const cv::Mat& current, const cv::Mat& reference);

  void keep_returning(const ImagePyramid& current, const ImagePyramid& reference);

  template <class Test>
  void keep(const Test& test);

  float border() const { return static_cast<float>(params_.border_px); }

  FlowParams params_;
  GuidedFlow guided_;
  std::vector<std::size_t> index_;  // of the points that are still tracked
  Points from_, start_, to_, back_;
  std::vector<std::uint8_t> status_;
  PatchResidual patches_;
  Points chained_, chain_start_;
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/correspondence/detail/flow-inl.hpp>
#endif
