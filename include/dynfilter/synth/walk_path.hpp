// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace dynfilter::synth {

/// A smooth closed path on the floor: uniform Catmull-Rom through the given points.
/// Parametrised by arc length, for all real s, including negative ones.
class WalkPath {
 public:
  explicit WalkPath(std::vector<Eigen::Vector2d> points) : points_(std::move(points)) {
    const int samples = kPerSegment * static_cast<int>(points_.size());
    length_.push_back(0);
    for (int i = 1; i <= samples; ++i) {
      length_.push_back(length_.back() +
                        (spline(i / double(kPerSegment)) - spline((i - 1) / double(kPerSegment))).norm());
    }
  }

  double length_m() const { return length_.back(); }

  Eigen::Vector2d at(double s_m) const {
    double s = std::fmod(s_m, length_m());
    if (s < 0) s += length_m();
    const auto above = std::upper_bound(length_.begin() + 1, length_.end() - 1, s);
    const auto i = static_cast<std::size_t>(above - length_.begin());
    const double t = (s - length_[i - 1]) / std::max(1e-12, length_[i] - length_[i - 1]);
    return spline((static_cast<double>(i) - 1 + t) / kPerSegment);
  }

  /// Unit direction of travel, averaged over 0.5 m, because people do not turn on the spot.
  Eigen::Vector2d heading(double s_m) const { return (at(s_m + 0.25) - at(s_m - 0.25)).normalized(); }

 private:
  static constexpr int kPerSegment = 32;

  Eigen::Vector2d spline(double u) const {
    const int n = static_cast<int>(points_.size());
    const int i = static_cast<int>(std::floor(u));
    const double t = u - i;
    const auto p = [&](int k) -> const Eigen::Vector2d& {
      return points_[static_cast<std::size_t>(((i + k) % n + n) % n)];
    };
    const Eigen::Vector2d a = -p(-1) + 3 * p(0) - 3 * p(1) + p(2), b = 2 * p(-1) - 5 * p(0) + 4 * p(1) - p(2);
    return 0.5 * (((a * t + b) * t + (p(1) - p(-1))) * t + 2 * p(0));
  }

  std::vector<Eigen::Vector2d> points_;
  std::vector<double> length_;
};

}  // namespace dynfilter::synth
