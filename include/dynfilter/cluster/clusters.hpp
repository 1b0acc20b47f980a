// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <opencv2/core/types.hpp>
#include <vector>

namespace dynfilter {

/// A point is a core point if at least `min_points` points, including itself, are within `eps_m`.
struct DbscanParams {
  double eps_m = 0.1;
  int min_points = 4;

  static constexpr double kMinEpsM = 1e-6, kMaxEpsM = 1e6;
};

/// One entry per point. Clusters are numbered from 0 in the order of their first points.
struct Clusters {
  static constexpr std::int32_t kNoise = -1;

  std::vector<std::int32_t> label;  ///< kNoise: in no cluster, or not finite
  std::vector<std::uint8_t> core;   ///< 1 for core points, else 0
  int count = 0;

  /// N points, none of them in a cluster.
  void reset(std::size_t n) {
    label.assign(n, kNoise);
    core.assign(n, 0);
    count = 0;
  }
  /// Renumbers the clusters in the order of their first points. Labels must be below `names`.
  void renumber(std::size_t names);

 private:
  std::vector<std::int32_t> numbers_;
};

namespace detail {

inline bool finite(const cv::Point3f& p) {
  return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

/// The only distance in this folder. Every search compares it with float(eps)^2.
inline float squared_distance(const cv::Point3f& a, const cv::Point3f& b) {
  const float dx = a.x - b.x, dy = a.y - b.y, dz = a.z - b.z;
  return dx * dx + dy * dy + dz * dz;
}
inline float squared_radius(double radius_m) {
  const auto r = static_cast<float>(radius_m);
  return r * r;
}

/// Cells of a grid are this much wider than the radius, so that rounding hides no neighbour.
constexpr double kCellMargin = 1.00001;

/// Union-find over 0..n-1.
/// The smaller root becomes the parent, so the result does not depend on the order of unions.
class DisjointSets {
 public:
  void reset(std::size_t n) {
    parent_.resize(n);
    for (std::size_t i = 0; i < n; ++i) parent_[i] = static_cast<std::uint32_t>(i);
  }
  std::uint32_t find(std::uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  bool unite(std::uint32_t a, std::uint32_t b) {
    a = find(a), b = find(b);
    if (a == b) return false;
    parent_[std::max(a, b)] = std::min(a, b);
    return true;
  }

 private:
  std::vector<std::uint32_t> parent_;
};

}  // namespace detail

inline void Clusters::renumber(std::size_t names) {
  numbers_.assign(names, kNoise);
  count = 0;
  for (std::int32_t& l : label) {
    if (l < 0) continue;
    std::int32_t& number = numbers_[static_cast<std::size_t>(l)];
    if (number < 0) number = count++;
    l = number;
  }
}

namespace detail {}  // namespace detail

}  // namespace dynfilter
