// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstdint>
#include <dynfilter/mapping/carving.hpp>
#include <dynfilter/mapping/map_cloud.hpp>
#include <dynfilter/mapping/map_params.hpp>
#include <dynfilter/mapping/outliers.hpp>
#include <dynfilter/mapping/voxel_key.hpp>
#include <dynfilter/mapping/voxel_map.hpp>
#include <vector>

namespace dynfilter::mapping {

/// Indices of the voxels that a map shows, in key order.
struct ShownVoxels {
  std::vector<std::uint32_t> fine, coarse;
};

namespace detail {

inline int log2_of(int power) {
  int bits = 0;
  while (power >> bits > 1) ++bits;
  return bits;
}

inline std::uint64_t without_label(std::uint64_t key) {
  return key & ((std::uint64_t{1} << (3 * VoxelKey::kAxisBits)) - 1);
}

inline std::vector<std::uint32_t> left_standing(const VoxelMap& map, const MappingParams& params) {
  const Carving carving(map, params.carve);
  std::vector<std::uint32_t> order = voxels_in_order(map, [&](std::uint32_t i) { return !carving.gone(i); });
  OutlierFilter(params.outliers).run(map, order);
  return order;
}

}  // namespace detail

/// Without voxels that were seen through (Carving) and isolated ones (OutlierFilter).
/// Without coarse voxels where fine voxels of key objects exist.
inline ShownVoxels shown_voxels(const VoxelMap& map, const VoxelMap& key_map, const MappingParams& params) {
  std::vector<std::uint64_t> refined;
  const int nested = detail::log2_of(params.key_divisor) + map.level() - key_map.level();
  for (const std::uint64_t key : key_map.keys())
    refined.push_back(detail::without_label(VoxelKey::coarser(key, nested)));
  std::sort(refined.begin(), refined.end());
  const auto is_refined = [&](std::uint64_t key) {
    return std::binary_search(refined.begin(), refined.end(), detail::without_label(key));
  };
  ShownVoxels shown{detail::left_standing(key_map, params), detail::left_standing(map, params)};
  shown.coarse.erase(std::remove_if(shown.coarse.begin(), shown.coarse.end(),
                                    [&](std::uint32_t i) { return is_refined(map.keys()[i]); }),
                     shown.coarse.end());
  return shown;
}

}  // namespace dynfilter::mapping
