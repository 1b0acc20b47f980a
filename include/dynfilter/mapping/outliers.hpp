// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <dynfilter/mapping/map_cloud.hpp>
#include <dynfilter/mapping/map_params.hpp>
#include <dynfilter/mapping/voxel_key.hpp>
#include <dynfilter/mapping/voxel_map.hpp>
#include <vector>

namespace dynfilter::mapping {

/// Statistical outlier removal on voxels (Rusu et al., Robotics and Autonomous Systems 2008, sec. 4.1).
/// Compares a voxel's mean distance to its nearest `neighbours` with the mean over all voxels plus `sigmas`
/// standard deviations. Larger distances and missing neighbours count as kReach leaves. An isolated voxel
/// then does not distort the statistics, and the search is local. Neighbours have the same class.
///
/// Cost: linear. Voxels in key order are rows along x. The 25 rows around a voxel advance with it, without
/// look-ups. The result depends only on the content of the map, not on its history.
class OutlierFilter {
 public:
  static constexpr int kReach = 2;

  explicit OutlierFilter(const OutlierParams& params) : params_(params) {}

  /// `order`: voxels in key order. Removes outliers from it.
  /// Does nothing if there are at most `neighbours` voxels.
  void run(const VoxelMap& map, std::vector<std::uint32_t>& order);

 private:
  static constexpr int kSide = 2 * kReach + 1;
  struct Nearest {
    std::array<float, 64> squared;  ///< increasing
    int wanted;
    /// The n smallest values.
    explicit Nearest(int n) : wanted(n) { squared.fill(static_cast<float>(kReach * kReach)); }
    void add(float d2);  ///< d2: squared distance [m2]
    /// Mean distance [m].
    float mean() const {
      float sum = 0;
      for (std::size_t k = 0; k < static_cast<std::size_t>(wanted); ++k) sum += std::sqrt(squared[k]);
      return sum / static_cast<float>(wanted);
    }
  };

  /// Reads keys, and the position of each centroid in its cell, in leaves.
  void read(const VoxelMap& map, const std::vector<std::uint32_t>& order);

  void measure(std::vector<float>& mean) const;
  float squared_distance(std::size_t i, std::size_t j, int dx, int dy, int dz) const;

  OutlierParams params_;
  std::vector<std::int64_t> keys_;
  std::vector<std::array<float, 3>> within_;
};

inline void OutlierFilter::run(const VoxelMap& map, std::vector<std::uint32_t>& order) {
  if (!params_.enabled || order.size() <= static_cast<std::size_t>(params_.neighbours)) return;
  read(map, order);
  std::vector<float> mean(order.size());
  measure(mean);
  double sum = 0, squares = 0;
  for (const float m : mean) {
    sum += static_cast<double>(m);
    squares += static_cast<double>(m) * static_cast<double>(m);
  }
  const double n = static_cast<double>(mean.size()), average = sum / n;
  const double limit = average + params_.sigmas * std::sqrt(std::max(0.0, squares / n - average * average));
  std::size_t left = 0;
  for (std::size_t i = 0; i < order.size(); ++i)
    if (static_cast<double>(mean[i]) <= limit) order[left++] = order[i];
  order.resize(left);
}

inline void OutlierFilter::Nearest::add(float d2) {
  if (!(d2 < squared[static_cast<std::size_t>(wanted) - 1])) return;
  std::size_t at = static_cast<std::size_t>(wanted) - 1;
  for (; at > 0 && squared[at - 1] > d2; --at) squared[at] = squared[at - 1];
  squared[at] = d2;
}

inline void OutlierFilter::read(const VoxelMap& map, const std::vector<std::uint32_t>& order) {
  const double leaf_units = std::ldexp(1.0, VoxelMap::kLeafBits + map.level());
  keys_.clear();
  within_.clear();
  for (const std::uint32_t i : order) {
    const std::uint64_t key = map.keys()[i];
    keys_.push_back(static_cast<std::int64_t>(key));
    std::array<float, 3> within;
    for (std::size_t a = 0; a < 3; ++a)
      within[a] = static_cast<float>(voxel_units(map.voxels()[i], a) / leaf_units -
                                     VoxelKey::axis(key, static_cast<int>(a)));
    within_.push_back(within);
  }
}

inline void OutlierFilter::measure(std::vector<float>& mean) const {
  std::array<std::size_t, kSide * kSide> row{};  // start of each row beside the current voxel
  for (std::size_t i = 0; i < keys_.size(); ++i) {
    Nearest nearest(params_.neighbours);
    for (int r = 0; r < kSide * kSide; ++r) {
      const int dy = r % kSide - kReach, dz = r / kSide - kReach;
      const std::int64_t first = keys_[i] + dz * (std::int64_t{1} << (2 * VoxelKey::kAxisBits)) +
                                 dy * (std::int64_t{1} << VoxelKey::kAxisBits) - kReach;
      std::size_t& j = row[static_cast<std::size_t>(r)];
      while (j < keys_.size() && keys_[j] < first) ++j;
      for (std::size_t k = j; k < keys_.size() && keys_[k] < first + kSide; ++k)
        if (k != i) nearest.add(squared_distance(i, k, static_cast<int>(keys_[k] - first) - kReach, dy, dz));
    }
    mean[i] = nearest.mean();
  }
}

inline float OutlierFilter::squared_distance(std::size_t i, std::size_t j, int dx, int dy, int dz) const {
  const std::array<float, 3>&a = within_[i], &b = within_[j];
  const float x = static_cast<float>(dx) + b[0] - a[0], y = static_cast<float>(dy) + b[1] - a[1],
              z = static_cast<float>(dz) + b[2] - a[2];
  return x * x + y * y + z * z;
}

}  // namespace dynfilter::mapping
