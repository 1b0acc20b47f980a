// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/mapping/map_cloud.hpp>

#include <dynfilter/core/inline.hpp>
#include <dynfilter/mapping/voxel_key.hpp>

namespace dynfilter::mapping {

DYNFILTER_INLINE void append_cloud(const VoxelMap& map, const std::vector<std::uint32_t>& order,
                                   double unit_m, MapCloud& cloud) {
  for (const std::uint32_t i : order) {
    const Voxel& v = map.voxels()[i];
    const auto coordinate = [&](std::size_t a) { return static_cast<float>(voxel_units(v, a) * unit_m); };
    const auto mean = [&](std::size_t c) {
      return static_cast<std::uint8_t>((v.colour[c] + v.points / 2) / v.points);
    };
    cloud.points_m.emplace_back(coordinate(0), coordinate(1), coordinate(2));
    cloud.colours.emplace_back(mean(0), mean(1), mean(2));
    cloud.classes.push_back(VoxelKey::label(map.keys()[i]));
  }
}

DYNFILTER_INLINE std::vector<std::uint32_t> SourceCollector::places(const VoxelMap& map,
                                                                    const std::vector<std::uint32_t>& order,
                                                                    std::size_t begin) {
  std::vector<std::uint32_t> place(map.size(), kHidden);
  for (const std::uint32_t i : order) place[i] = static_cast<std::uint32_t>(begin++);
  return place;
}

DYNFILTER_INLINE void SourceCollector::add(const VoxelMap& map, const std::vector<std::uint32_t>& place,
                                           const std::vector<WorldPoint>& points, std::uint32_t keyframe) {
  for (const WorldPoint& p : points) {
    const std::uint32_t i = map.find(map.key_of(p));
    if (i != VoxelMap::kNone && place[i] != kHidden)
      pairs_.push_back(std::uint64_t{place[i]} << 32 | keyframe);
  }
}

}  // namespace dynfilter::mapping
