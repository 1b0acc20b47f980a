// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <dynfilter/config/parameters.hpp>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/portable_math.hpp>
#include <dynfilter/correspondence/correspondence_params.hpp>
#include <dynfilter/correspondence/correspondences.hpp>
#include <dynfilter/correspondence/guided_flow.hpp>
#include <dynfilter/correspondence/image_pyramid.hpp>
#include <dynfilter/correspondence/lucas_kanade.hpp>
#include <dynfilter/correspondence/patch_residual.hpp>
#include <opencv2/core.hpp>
#include <opencv2/video/tracking.hpp>
#include <vector>

namespace dynfilter {

/// Pyramidal Lucas-Kanade flow (Bouguet 2000) from the current frame's features back to a reference frame.
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

  /// What a guided track() needs of these pyramids alone, which must not change until forget_prepared().
  void prepare(const ImagePyramid& current, const ImagePyramid& reference) {
    if (guided()) guided_.prepare(current, reference);
  }
  void forget_prepared() { guided_.forget_prepared(); }  ///< the pyramids have changed

  /// `current_px` are distorted pixels. `guess` is the expected position of each point in the reference
  /// frame, NaN if unknown. An empty `guess` means no motion. Points that are NaN, outside the image or fail
  /// the check are not found. Images of different size find nothing. Cost: see docs/reference/results.md.
  void track(const ImagePyramid& current, const ImagePyramid& reference, Span<const cv::Point2f> current_px,
             Span<const cv::Point2f> guess, Correspondences& out);

 private:
  using Points = std::vector<cv::Point2f>;

  static const FlowParams& checked(const FlowParams& params) {
    check_parameters(params, "flow");
    return params;
  }

  void collect(const cv::Size& size, Span<const cv::Point2f> current_px, Span<const cv::Point2f> guess);

  bool guided() const {
    return params_.engine == FlowEngine::Guided && GuidedFlow::supports(params_.window_px);
  }
  bool own() const {
    return params_.engine != FlowEngine::OpenCv && LucasKanade::supports(params_.window_px);
  }

  /// OpenCV's does not tell its gradients: then nothing is known of the spread.
  void lucas_kanade(const ImagePyramid& a, const ImagePyramid& b, const Points& from, Points& to,
                    std::vector<MatchSpread>& spread);

  void keep_inside(const cv::Size& size) {
    keep([&](std::size_t k) { return status_[k] != 0 && detail::inside(to_[k], size, border()); });
  }
  void keep_alike(const cv::Mat& current, const cv::Mat& reference) {
    keep([&](std::size_t k) {
      return patches_(current, from_[k], reference, to_[k]) <= FlowLimits::kMaxResidual;
    });
  }
  void keep_returning(const ImagePyramid& current, const ImagePyramid& reference);

  template <class Test>
  void keep(const Test& test);

  float border() const { return static_cast<float>(params_.border_px); }

  FlowParams params_;
  GuidedFlow guided_;
  std::vector<std::size_t> index_;  // of the points that are still tracked
  Points from_, start_, to_, back_;
  std::vector<std::uint8_t> status_;
  std::vector<MatchSpread> spread_, back_spread_;
  PatchResidual patches_;
};

inline void FlowTracker::track(const ImagePyramid& current, const ImagePyramid& reference,
                               Span<const cv::Point2f> current_px, Span<const cv::Point2f> guess,
                               Correspondences& out) {
  out.reset(current_px.size());
  if (!current.fits(reference) || current.window_px() != params_.window_px) return;
  if (!guess.empty() && guess.size() != current_px.size()) guess = {};
  collect(current.size(), current_px, guess);
  if (index_.empty()) return;
  if (guided()) {
    guided_.track(current, reference, params_.check, from_, to_, status_, spread_);
    keep_inside(current.size());
  } else {
    lucas_kanade(current, reference, from_, to_, spread_);
    keep_inside(current.size());
    if (params_.check != FlowCheck::None) keep_alike(current.image(), reference.image());
    if (params_.check == FlowCheck::ForwardBackward) keep_returning(current, reference);
  }
  for (std::size_t k = 0; k < index_.size(); ++k) {
    out.set(index_[k], to_[k]);
    out.spread[index_[k]] = spread_[k];
  }
}

inline void FlowTracker::collect(const cv::Size& size, Span<const cv::Point2f> current_px,
                                 Span<const cv::Point2f> guess) {
  index_.clear();
  from_.clear();
  start_.clear();
  for (std::size_t i = 0; i < current_px.size(); ++i) {
    if (!detail::inside(current_px[i], size, border())) continue;
    const bool guessed = !guess.empty() && detail::inside(guess[i], size, 0);
    index_.push_back(i);
    from_.push_back(current_px[i]);
    start_.push_back(guessed ? guess[i] : current_px[i]);
  }
  to_ = start_;
}

inline void FlowTracker::lucas_kanade(const ImagePyramid& a, const ImagePyramid& b, const Points& from,
                                      Points& to, std::vector<MatchSpread>& spread) {
  if (own()) {
    const LucasKanade tracker{params_.window_px, params_.levels, params_.max_iterations, params_.epsilon_px,
                              FlowLimits::kMinEigenvalue};
    return tracker.track(a.levels(), b.levels(), 1, from, to, status_, spread);
  }
  spread.assign(from.size(), {});
  const cv::TermCriteria criteria(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, params_.max_iterations,
                                  params_.epsilon_px);
  cv::calcOpticalFlowPyrLK(a.levels(), b.levels(), from, to, status_, cv::noArray(),
                           {params_.window_px, params_.window_px}, params_.levels, criteria,
                           cv::OPTFLOW_USE_INITIAL_FLOW, FlowLimits::kMinEigenvalue);
}

inline void FlowTracker::keep_returning(const ImagePyramid& current, const ImagePyramid& reference) {
  if (index_.empty()) return;
  // Tracking back must not start from the answer: its guess is the expected motion.
  back_.resize(to_.size());
  for (std::size_t k = 0; k < to_.size(); ++k) back_[k] = to_[k] + (from_[k] - start_[k]);
  lucas_kanade(reference, current, to_, back_, back_spread_);
  keep([&](std::size_t k) {
    const cv::Point2f miss = back_[k] - from_[k];
    return status_[k] != 0 &&
           static_cast<double>(portable::hypot(miss.x, miss.y)) <= FlowLimits::kMaxForwardBackward_px;
  });
}

template <class Test>
void FlowTracker::keep(const Test& test) {
  std::size_t kept = 0;
  for (std::size_t k = 0; k < index_.size(); ++k) {
    if (!test(k)) continue;
    index_[kept] = index_[k];
    from_[kept] = from_[k];
    start_[kept] = start_[k];
    to_[kept] = to_[k];
    spread_[kept] = spread_[k];
    ++kept;
  }
  index_.resize(kept);
  from_.resize(kept);
  start_.resize(kept);
  to_.resize(kept);
  spread_.resize(kept);
}

}  // namespace dynfilter
