// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <dynfilter/core/simd.hpp>
#include <dynfilter/geometry/small_matrix.hpp>
#include <dynfilter/motion/detail/view_motion_terms.hpp>
#include <dynfilter/motion/view_motion.hpp>
#include <numeric>
#include <vector>

namespace dynfilter {

namespace detail {
class ViewMotionEquations;
}

/// Gauss-Newton on the distances of points from their epipolar lines, eight points at a time. Without a
/// baseline, it uses the flow that the rotation does not explain. Normal equations are sums of floats: their
/// error is far below the noise of any flow. Cost: O(n) per iteration.
class ViewMotionFit {
 public:
  /// Limits of the fit.
  struct Options {
    double sigma_px = 1;  ///< scale of the Cauchy weights; 0: plain squares
    int iterations = 6;   ///< at most
    /// Ends when a step changes the weighted residuals by less than this, RMS; far below the noise of a flow.
    double settled_px = 0.005;
  };

  /// Selects `pairs[i]`, i in `which`, with `weights[i]`. Empty weights are 1.
  void select(const std::vector<ViewPair>& pairs, const std::vector<int>& which,
              const std::vector<double>& weights);

  /// Fits the selected pairs, starting from `motion`.
  ViewMotion refine(ViewMotion motion, const Options& options) const;

 private:
  /// Returns the sum of the weights.
  double fill(const ViewMotion& motion, double sigma_px, detail::ViewMotionEquations& equations) const;

  std::vector<float> reference_x_, reference_y_, x_, y_;
  std::vector<float> weight_;  ///< 0 in the padding to whole packs
};

namespace detail {

inline ViewMotionEquations::ViewMotionEquations(const ViewMotion& motion)
    : n_(motion.has_baseline() ? 5 : 3), turns_(turns_by_step(motion.rotation_rad)) {
  std::fill_n(products_, 15, Pack(0));
  std::fill_n(rhs_, 5, Pack(0));
}

inline bool ViewMotionEquations::solve(double (&step)[5]) {
  std::size_t at = 0;
  for (int p = 0; p < n_; ++p) {
    b_[p] = static_cast<double>(rhs_[p].sum());
    for (int q = 0; q <= p; ++q, ++at)
      A_[p * n_ + q] = A_[q * n_ + p] = static_cast<double>(products_[at].sum());
  }
  by_rotation_vector();
  double slope[5];
  std::copy_n(b_, 5, slope);
  for (int p = 0; p < n_; ++p) A_[p * n_ + p] = A_[p * n_ + p] * 1.001 + 1e-6;
  if (!solve_positive_definite(A_, b_, n_)) return false;
  for (int k = 0; k < n_; ++k) step[k] = b_[k];
  change_ = std::inner_product(slope, slope + n_, step, 0.0);
  return true;
}

inline void ViewMotionEquations::by_rotation_vector() {
  for (int p = 0; p < n_; ++p) turn(&A_[p * n_], 1);
  for (int q = 0; q < n_; ++q) turn(&A_[q], n_);
  turn(b_, 1);
}

inline void ViewMotionEquations::turn(double* first, int stride) const {
  const double v[3] = {first[0], first[stride], first[2 * stride]};
  for (std::size_t k = 0; k < 3; ++k)
    first[static_cast<int>(k) * stride] = turns_[k][0] * v[0] + turns_[k][1] * v[1] + turns_[k][2] * v[2];
}

}  // namespace detail

inline void ViewMotionFit::select(const std::vector<ViewPair>& pairs, const std::vector<int>& which,
                                  const std::vector<double>& weights) {
  constexpr std::size_t kWidth = detail::Pack::kWidth;
  const std::size_t n = which.size(), padded = (n + kWidth - 1) / kWidth * kWidth;
  for (std::vector<float>* column : {&reference_x_, &reference_y_, &x_, &y_, &weight_})
    column->assign(padded, 0);
  for (std::size_t k = 0; k < n; ++k) {
    const auto i = static_cast<std::size_t>(which[k]);
    reference_x_[k] = static_cast<float>(pairs[i].reference_x);
    reference_y_[k] = static_cast<float>(pairs[i].reference_y);
    x_[k] = static_cast<float>(pairs[i].x);
    y_[k] = static_cast<float>(pairs[i].y);
    weight_[k] = weights.empty() ? 1.0F : static_cast<float>(weights[i]);
  }
}

inline ViewMotion ViewMotionFit::refine(ViewMotion motion, const Options& options) const {
  for (int iteration = 0; iteration < options.iterations; ++iteration) {
    detail::ViewMotionEquations equations(motion);
    const double weight = fill(motion, options.sigma_px, equations);
    double step[5] = {}, largest = 0;
    if (!equations.solve(step)) break;
    for (const double x : step) largest = std::max(largest, std::abs(x));
    if (!(largest < 1e6)) break;
    const double shorten = largest > 0.5 ? 0.5 / largest : 1;  // at most half a radian
    for (double& x : step) x *= shorten;
    motion = detail::stepped(motion, step);
    if (equations.change() < options.settled_px * options.settled_px * weight) break;
  }
  return motion;
}

inline double ViewMotionFit::fill(const ViewMotion& motion, double sigma_px,
                                  detail::ViewMotionEquations& equations) const {
  using detail::Pack;
  const detail::ViewMotionTerms<Pack> terms(motion);
  const Pack inverse2(sigma_px > 0 ? static_cast<float>(1 / (sigma_px * sigma_px)) : 0.0F);
  Pack total(0);
  for (std::size_t k = 0; k < weight_.size(); k += Pack::kWidth) {
    const Pack ax = Pack::load(&reference_x_[k]), ay = Pack::load(&reference_y_[k]), x = Pack::load(&x_[k]),
               y = Pack::load(&y_[k]), given = Pack::load(&weight_[k]);
    Pack ahead;
    if (motion.has_baseline()) {
      const auto t = terms.across(ax, ay, x, y, ahead);
      const Pack weight = above(ahead, 0) * given / (t.squared + t.cross * t.cross * inverse2);
      equations.add<5>(t.cross, weight, t.by);
      total += weight * t.squared;
    } else {
      const auto t = terms.rest(ax, ay, x, y, ahead);
      const Pack squared = t.px[0] * t.px[0] + t.px[1] * t.px[1];
      const Pack weight = above(ahead, 0) * given / (1 + squared * inverse2);
      for (int axis = 0; axis < 2; ++axis) equations.add<3>(t.px[axis], weight, t.by[axis]);
      total += weight;
    }
  }
  return static_cast<double>(total.sum());
}

}  // namespace dynfilter
