// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>
#include <unordered_set>
#include <vector>

namespace dynfilter::command::report {

/// Points of the map of one run, and of the maps of all runs of a report. 12 bytes each in base64.
constexpr std::size_t kMostMapPoints = 60'000, kMapPointsOfAllRuns = 60'000;

namespace detail {

/// Indices of the first point in each cell of a grid.
inline std::vector<std::size_t> one_per_cell(const std::vector<cv::Point3f>& points_m, double cell_m) {
  constexpr std::int64_t kOffset = 1 << 20;  // in the middle of 21 bits
  const auto part = [cell_m](float coordinate_m) {
    const auto cell = static_cast<std::int64_t>(std::floor(static_cast<double>(coordinate_m) / cell_m));
    return static_cast<std::uint64_t>(cell + kOffset) & 0x1FFFFFU;
  };
  std::unordered_set<std::uint64_t> taken;
  std::vector<std::size_t> indices;
  for (std::size_t i = 0; i < points_m.size(); ++i) {
    const cv::Point3f& p = points_m[i];
    if (taken.insert(part(p.x) << 42 | part(p.y) << 21 | part(p.z)).second) indices.push_back(i);
  }
  return indices;
}

}  // namespace detail

/// Indices of at most `most` points, evenly in space: key objects of a map have much finer voxels than the
/// rest. Cost: a hash of the points, two or three times.
inline std::vector<std::size_t> map_sample(const std::vector<cv::Point3f>& points_m, std::size_t most) {
  double cell_m = 0.01;  // finer is not seen on a screen
  std::vector<std::size_t> sample = detail::one_per_cell(points_m, cell_m);
  while (sample.size() > most) {
    // A surface has a quarter of the cells when they are twice as wide.
    cell_m *= 1.05 * std::sqrt(static_cast<double>(sample.size()) / static_cast<double>(most));
    sample = detail::one_per_cell(points_m, cell_m);
  }
  return sample;
}

}  // namespace dynfilter::command::report
