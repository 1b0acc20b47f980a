// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <dynfilter/mapping/map_params.hpp>
#include <dynfilter/mapping/voxel_map.hpp>
#include <vector>

namespace dynfilter::mapping {

/// Statistical outlier removal on voxels
/// (Rusu et al., Robotics and Autonomous Systems 2008, sec. 4.1).
/// Compares a voxel's mean distance to its nearest `neighbours`
/// with the mean over all voxels plus `sigmas` standard deviations.
/// Larger distances and missing neighbours count as kReach leaves.
/// An isolated voxel then does not distort the statistics, and the search is local.
/// Neighbours have the same class.
///
/// Cost: linear. Voxels in key order are rows along x.
/// The 25 rows around a voxel advance with it, without look-ups.
/// The result depends only on the content of the map, not on its history.
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
    explicit Nearest(int n);
    void add(float d2);
    float mean() const;
  };

  /// Reads keys, and the position of each centroid in its cell, in leaves.
  void read(const VoxelMap& map, const std::vector<std::uint32_t>& order);

  void measure(std::vector<float>& mean) const;
  float squared_distance(std::size_t i, std::size_t j, int dx, int dy, int dz) const;

  OutlierParams params_;
  std::vector<std::int64_t> keys_;
  std::vector<std::array<float, 3>> within_;
};

}  // namespace dynfilter::mapping

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/mapping/detail/outliers-inl.hpp>
#endif
