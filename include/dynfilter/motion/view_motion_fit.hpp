// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/motion/view_motion.hpp>
#include <vector>

namespace dynfilter {

namespace detail {
class ViewMotionEquations;
}

/// Gauss-Newton on the distances of points from their epipolar lines, eight points at a time.
/// Without a baseline, it uses the flow that the rotation does not explain.
/// Normal equations are sums of floats: their error is far below the noise of any flow.
/// Cost: O(n) per iteration.
class ViewMotionFit {
 public:
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

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/motion/detail/view_motion_fit-inl.hpp>
#endif
