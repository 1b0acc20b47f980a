// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/correspondence/flow.hpp>

#include <dynfilter/core/inline.hpp>
#include <dynfilter/config/parameters.hpp>
#include <dynfilter/core/portable_math.hpp>
#include <opencv2/core.hpp>
#include <opencv2/video/tracking.hpp>

namespace dynfilter {

DYNFILTER_INLINE void FlowTracker::track_chain(const ImagePyramid& current,
                                               Span<const ImagePyramid* const> steps,
                                               Span<const cv::Point2f> current_px, Correspondences& out) {
  if (steps.size() < 2) {
    const ImagePyramid none;
    return track(current, steps.empty() ? none : *steps[0], current_px, {}, out);
  }
  chained_.assign(current_px.begin(), current_px.end());
  const ImagePyramid* from = &current;
  for (const ImagePyramid* to : steps) {
    track(*from, *to, chained_, {}, FlowCheck::None, out);
    chained_ = out.reference_px;  // NaN marks a lost point and is passed on
    from = to;
  }
  chain_start_.assign(current_px.begin(), current_px.end());
  for (std::size_t i = 0; i < chain_start_.size(); ++i)
    if (!detail::finite(chained_[i])) chain_start_[i] = chained_[i];
  track(current, *from, chain_start_, chained_, out);
}

DYNFILTER_INLINE const FlowParams& FlowTracker::checked(const FlowParams& params) {
  check_parameters(params, "flow");
  return params;
}

DYNFILTER_INLINE void FlowTracker::track(const ImagePyramid& current, const ImagePyramid& reference,
                                         Span<const cv::Point2f> current_px, Span<const cv::Point2f> guess,
                                         FlowCheck check, Correspondences& out) {
  out.reset(current_px.size());
  if (!current.fits(reference) || current.window_px() != params_.window_px) return;
  if (!guess.empty() && guess.size() != current_px.size()) guess = {};
  collect(current.size(), current_px, guess);
  if (index_.empty()) return;
  if (guided()) {
    guided_.track(current, reference, check, from_, to_, status_);
    keep_inside(current.size());
  } else {
    lucas_kanade(current, reference, from_, to_);
    keep_inside(current.size());
    check_each(current, reference, check);
  }
  for (std::size_t k = 0; k < index_.size(); ++k) out.set(index_[k], to_[k]);
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

DYNFILTER_INLINE void FlowTracker::lucas_kanade(const ImagePyramid& a, const ImagePyramid& b,
                                                const Points& from, Points& to) {
  if (own()) {
    const LucasKanade tracker{params_.window_px, params_.levels, params_.max_iterations, params_.epsilon_px,
                              params_.min_eigenvalue};
    return tracker.track(a.levels(), b.levels(), 1, from, to, status_);
  }
  const cv::TermCriteria criteria(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, params_.max_iterations,
                                  params_.epsilon_px);
  cv::calcOpticalFlowPyrLK(a.levels(), b.levels(), from, to, status_, cv::noArray(),
                           {params_.window_px, params_.window_px}, params_.levels, criteria,
                           cv::OPTFLOW_USE_INITIAL_FLOW, params_.min_eigenvalue);
}

inline void FlowTracker::keep_inside(const cv::Size& size) {
  keep([&](std::size_t k) { return status_[k] != 0 && detail::inside(to_[k], size, border()); });
}

inline void FlowTracker::check_each(const ImagePyramid& current, const ImagePyramid& reference,
                                    FlowCheck check) {
  if (check != FlowCheck::None) keep_alike(current.image(), reference.image());
  if (check == FlowCheck::ForwardBackward) keep_returning(current, reference);
}

inline void FlowTracker::keep_alike(const cv::Mat& current, const cv::Mat& reference) {
  keep([&](std::size_t k) { return patches_(current, from_[k], reference, to_[k]) <= params_.max_residual; });
}

inline void FlowTracker::keep_returning(const ImagePyramid& current, const ImagePyramid& reference) {
  if (index_.empty()) return;
  // Tracking back must not start from the answer: its guess is the expected motion.
  back_.resize(to_.size());
  for (std::size_t k = 0; k < to_.size(); ++k) back_[k] = to_[k] + (from_[k] - start_[k]);
  lucas_kanade(reference, current, to_, back_);
  keep([&](std::size_t k) {
    const cv::Point2f miss = back_[k] - from_[k];
    return status_[k] != 0 &&
           static_cast<double>(portable::hypot(miss.x, miss.y)) <= params_.max_forward_backward_px;
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
    ++kept;
  }
  index_.resize(kept);
  from_.resize(kept);
  start_.resize(kept);
  to_.resize(kept);
}

}  // namespace dynfilter
