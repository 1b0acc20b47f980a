// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <vector>

namespace dynfilter::render {

/// A smooth closed path on the floor: uniform Catmull-Rom through the given points.
/// Parametrised by arc length, for all real s, including negative ones.
class WalkPath {
 public:
  explicit WalkPath(std::vector<Eigen::Vector2d> points);

  double length_m() const { return length_.back(); }

  Eigen::Vector2d at(double s_m) const;

  /// Unit direction of travel, averaged over 0.5 m, because people do not turn on the spot.
  Eigen::Vector2d heading(double s_m) const { return (at(s_m + 0.25) - at(s_m - 0.25)).normalized(); }

 private:
  static constexpr int kPerSegment = 32;

  Eigen::Vector2d spline(double u) const;

  std::vector<Eigen::Vector2d> points_;
  std::vector<double> length_;
};

}  // namespace dynfilter::render
