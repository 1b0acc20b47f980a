// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/span.hpp>
#include <dynfilter/geometry/two_view_model.hpp>
#include <memory>
#include <opencv2/core.hpp>

namespace dynfilter {

namespace detail {
class TwoViewSearch;
}

/// Selects the two-view model that the seeds obey and that may judge the other features.
///
/// F is fitted by RANSAC over seven matches with MSAC scores of Sampson distances.
/// It uses the oriented constraint, spatially spread samples, bail-out and local optimisation.
/// A plane, a pure rotation, no motion or a tiny baseline leave two parameters of F free.
/// Movers then determine these parameters (Torr, Zisserman and Maybank, CVIU 1998; DEGENSAC: Chum, Werner and
/// Matas, CVPR 2005). two_view_decision.hpp tests for these cases.
///
/// Reuses its buffers: no allocation after the largest input.
/// Cost: about 0.2 ms for 1000 seeds with 30 % outliers, 0.5 ms with 50 %.
class TwoViewEstimator {
 public:
  explicit TwoViewEstimator(const TwoViewOptions& options = {});
  TwoViewEstimator(TwoViewEstimator&&) noexcept;
  TwoViewEstimator& operator=(TwoViewEstimator&&) noexcept;
  ~TwoViewEstimator();

  TwoViewOptions& options() { return *options_; }
  const TwoViewOptions& options() const { return *options_; }

  /// Both spans are undistorted pixels and have the same size. `seeds` are the indices of the features to
  /// fit. Indices out of range and positions that are not finite are ignored. With a `camera` (intrinsics
  /// only) the estimator separates a rotation from a plane, and parallax from movers. Unusual data never
  /// throws; the result is kind None.
  TwoViewModel estimate(Span<const cv::Point2f> reference, Span<const cv::Point2f> current,
                        Span<const int> seeds, const Camera* camera = nullptr);

 private:
  std::unique_ptr<TwoViewOptions> options_;
  std::unique_ptr<detail::TwoViewSearch> search_;
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/geometry/detail/two_view-inl.hpp>
#endif
