// SPDX-License-Identifier: MIT
#include "render/walk_path.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

namespace dynfilter::render {

WalkPath::WalkPath(std::vector<Eigen::Vector2d> points) : points_(std::move(points)) {
  const int samples = kPerSegment * static_cast<int>(points_.size());
  length_.push_back(0);
  for (int i = 1; i <= samples; ++i) {
    length_.push_back(length_.back() +
                      (spline(i / double(kPerSegment)) - spline((i - 1) / double(kPerSegment))).norm());
  }
}

Eigen::Vector2d WalkPath::at(double s_m) const {
  double s = std::fmod(s_m, length_m());
  if (s < 0) s += length_m();
  const auto above = std::upper_bound(length_.begin() + 1, length_.end() - 1, s);
  const auto i = static_cast<std::size_t>(above - length_.begin());
  const double t = (s - length_[i - 1]) / std::max(1e-12, length_[i] - length_[i - 1]);
  return spline((static_cast<double>(i) - 1 + t) / kPerSegment);
}

inline Eigen::Vector2d WalkPath::spline(double u) const {
  const int n = static_cast<int>(points_.size());
  const int i = static_cast<int>(std::floor(u));
  const double t = u - i;
  const auto p = [&](int k) -> const Eigen::Vector2d& {
    return points_[static_cast<std::size_t>(((i + k) % n + n) % n)];
  };
  const Eigen::Vector2d a = -p(-1) + 3 * p(0) - 3 * p(1) + p(2), b = 2 * p(-1) - 5 * p(0) + 4 * p(1) - p(2);
  return 0.5 * (((a * t + b) * t + (p(1) - p(-1))) * t + 2 * p(0));
}

}  // namespace dynfilter::render
