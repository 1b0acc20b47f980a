// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <dynfilter/mapping/map_frame.hpp>
#include <dynfilter/mapping/voxel_key.hpp>
#include <dynfilter/mapping/voxel_map.hpp>
#include <vector>

namespace dynfilter::mapping {

/// Indices of the voxels that `shown(index)` accepts, in key order.
/// Equal maps give equal lists, independent of their history.
template <class Shown>
std::vector<std::uint32_t> voxels_in_order(const VoxelMap& map, const Shown& shown) {
  std::vector<std::uint32_t> order;
  for (std::uint32_t i = 0; i < map.size(); ++i)
    if (shown(i)) order.push_back(i);
  std::sort(order.begin(), order.end(),
            [&](std::uint32_t a, std::uint32_t b) { return map.keys()[a] < map.keys()[b]; });
  return order;
}

/// Centroid of a voxel in quanta of the map.
inline double voxel_units(const Voxel& v, std::size_t axis) {
  return static_cast<double>(v.weighted_units[axis]) / static_cast<double>(v.weight) + 0.5;
}

/// Collects which keyframes contribute to which points of a cloud.
class SourceCollector {
 public:
  static constexpr std::uint32_t kHidden = ~std::uint32_t{0};

  /// Positions of a map's voxels in the cloud. `begin`: position of the first one in `order`.
  static std::vector<std::uint32_t> places(const VoxelMap& map, const std::vector<std::uint32_t>& order,
                                           std::size_t begin) {
    std::vector<std::uint32_t> place(map.size(), kHidden);
    for (const std::uint32_t i : order) place[i] = static_cast<std::uint32_t>(begin++);
    return place;
  }
  /// `keyframe`: increasing numbers.
  void add(const VoxelMap& map, const std::vector<std::uint32_t>& place,
           const std::vector<WorldPoint>& points, std::uint32_t keyframe);
  /// `id(k)` and `stamp_s(k)` of keyframe number k.
  template <class Id, class Stamp>
  MapSources finish(std::size_t points, const Id& id, const Stamp& stamp_s) {
    std::sort(pairs_.begin(), pairs_.end());
    pairs_.erase(std::unique(pairs_.begin(), pairs_.end()), pairs_.end());
    MapSources sources;
    sources.first.reserve(points + 1);
    std::size_t at = 0;
    for (std::size_t i = 0; i < points; ++i) {
      for (; at < pairs_.size() && pairs_[at] >> 32 == i; ++at) {
        const auto k = static_cast<std::uint32_t>(pairs_[at]);
        sources.ids.push_back(id(k));
        sources.timestamps_s.push_back(stamp_s(k));
      }
      sources.first.push_back(static_cast<std::uint32_t>(at));
    }
    return sources;
  }

 private:
  std::vector<std::uint64_t> pairs_;  ///< place << 32 | keyframe
};

/// Appends centroids [m], mean colours and classes. `unit_m`: quantum of the map.
inline void append_cloud(const VoxelMap& map, const std::vector<std::uint32_t>& order, double unit_m,
                         MapCloud& cloud) {
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

inline void SourceCollector::add(const VoxelMap& map, const std::vector<std::uint32_t>& place,
                                 const std::vector<WorldPoint>& points, std::uint32_t keyframe) {
  for (const WorldPoint& p : points) {
    const std::uint32_t i = map.find(map.key_of(p));
    if (i != VoxelMap::kNone && place[i] != kHidden)
      pairs_.push_back(std::uint64_t{place[i]} << 32 | keyframe);
  }
}

}  // namespace dynfilter::mapping
