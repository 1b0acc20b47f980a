// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/compiled.hpp>
#include <dynfilter/core/span.hpp>
#include <dynfilter/geometry/two_view_model.hpp>
#include <memory>
#include <opencv2/core.hpp>

namespace dynfilter {

namespace detail {
class TwoViewSearch;
}

/// Which two-view model do the seeds obey, and which one may judge the rest?
///
/// F by RANSAC over seven matches: MSAC scores of Sampson distances, oriented constraint, samples spread over
/// the image, bail-out, local optimisation. Then the question whether F means anything, because a plane, a
/// pure rotation, no motion or a tiny baseline leave two of its parameters free, and these absorb whatever
/// moves (Torr, Zisserman and Maybank, CVIU 1998; Chum, Werner and Matas, CVPR 2005: DEGENSAC). See
/// two_view_decision.hpp for the criterion. Owns its scratch: no allocation once it has seen the largest
/// input. About 0.2 ms for 1000 seeds with 30 % outliers, 0.5 ms with 50 %.
class TwoViewEstimator {
 public:
  explicit TwoViewEstimator(const TwoViewOptions& options = {});
  TwoViewEstimator(TwoViewEstimator&&) noexcept;
  TwoViewEstimator& operator=(TwoViewEstimator&&) noexcept;
  ~TwoViewEstimator();

  TwoViewOptions& options() { return *options_; }
  const TwoViewOptions& options() const { return *options_; }

  /// Undistorted pixels, both spans of the same size; `seeds`: indices of the features to fit, out-of-range
  /// and non-finite ones are ignored. With a `camera` (intrinsics only) a rotation can be told from a plane,
  /// and parallax from movers. Never throws on odd data: kind None.
  TwoViewModel estimate(Span<const cv::Point2f> reference, Span<const cv::Point2f> current,
                        Span<const int> seeds, const Camera* camera = nullptr);

 private:
  std::unique_ptr<TwoViewOptions> options_;
  std::unique_ptr<detail::TwoViewSearch> search_;
};

}  // namespace dynfilter

#ifndef DYNFILTER_COMPILED
#include <dynfilter/geometry/two_view_search.hpp>
#endif
