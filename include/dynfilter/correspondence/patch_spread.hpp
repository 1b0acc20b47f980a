// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <dynfilter/core/frame_view.hpp>

namespace dynfilter {

namespace detail {

/// Unit eigenvector of the larger eigenvalue of (xx, xy; xy, yy), and both eigenvalues.
struct Axes2 {
  double x = 1, y = 0, most = 0, least = 0;
};
inline Axes2 axes_of(double xx, double xy, double yy) {
  const double apart = xx - yy, root = std::sqrt(apart * apart + 4 * xy * xy);
  Axes2 axes;
  axes.most = (xx + yy + root) / 2;
  if (!(axes.most > 0)) return axes;
  axes.least = std::max(0.0, (xx * yy - xy * xy) / axes.most);
  if (!(root > 0)) return axes;
  axes.x = std::sqrt((1 + apart / root) / 2);
  axes.y = std::copysign(std::sqrt((1 - apart / root) / 2), xy);
  return axes;
}

}  // namespace detail

/// Of the match of a patch, by the symmetric matrix (xx, xy; xy, yy) of its gradients: sums of products, in
/// any unit. With the ratio q of the eigenvalues, along = (kCorner / q)^4, which is fitted. The inverse of
/// the sums says less: along an edge the patch meets others that look alike.
class PatchSpread {
 public:
  static constexpr double kCorner = 0.05;  ///< ratio of the eigenvalues from which on nothing slides
  static constexpr double kMost = 1e4;     ///< a deviation of 100 times the noise: nothing is known
  static constexpr double kLeastRatio = 1e-9;

  /// From the sums of the products of a patch's gradients.
  static MatchSpread of(double xx, double xy, double yy) {
    MatchSpread spread;
    const detail::Axes2 axes = detail::axes_of(xx, xy, yy);
    if (!(axes.most > 0) || axes.least >= kCorner * axes.most) return spread;
    const double over = kCorner * axes.most / std::max(axes.least, kLeastRatio * axes.most);
    spread.along = static_cast<float>(std::min(kMost, over * over * over * over));
    spread.edge = {static_cast<float>(-axes.y), static_cast<float>(axes.x)};
    return spread;
  }
};

}  // namespace dynfilter
