// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <dynfilter/mapping/map_params.hpp>
#include <dynfilter/mapping/voxel_key.hpp>
#include <dynfilter/mapping/voxel_map.hpp>
#include <vector>

namespace dynfilter::mapping {

/// The voxels of a map that free space removes. First, voxels that enough keyframes saw through are removed
/// (CarveParams). Then the removal spreads to the remains of the same object. A person who left is mostly
/// seen through, except in front of pixels without depth. A voxel is also removed if at most
/// `spread_max_seen` keyframes saw it and at least `spread_share` of its neighbours within two cells are
/// removed. This repeats until nothing changes. The result does not depend on the order, because a removal
/// only favours further removals.
class Carving {
 public:
  /// Neighbours have the same class. Cost: one test per voxel, and 124 look-ups per voxel that few keyframes
  /// saw and that has a removed neighbour.
  Carving(const VoxelMap& map, const CarveParams& params);

  bool gone(std::size_t i) const { return gone_[i] != 0; }  ///< whether voxel i is removed

 private:
  static int seen(const VoxelVotes& v) { return v.seen + v.old_seen; }
  bool seen_through(const VoxelVotes& v) const {
    const int through = v.through + v.old_through;
    return through >= min_views_ && seen(v) < CarveParams::kSeenPerThrough * through;
  }
  void spread(std::vector<std::uint32_t>& open);
  bool outnumbered(std::uint32_t i) const;
  template <class F>
  void for_each_neighbour(std::uint32_t i, const F& f) const;

  static constexpr std::int32_t kReach = 2;
  const VoxelMap& map_;
  int min_views_;
  std::vector<std::uint8_t> gone_;
};

inline Carving::Carving(const VoxelMap& map, const CarveParams& params)
    : map_(map), min_views_(params.min_views), gone_(map.size(), 0) {
  if (!params.enabled) return;
  std::vector<std::uint32_t> open;
  for (std::uint32_t i = 0; i < map.size(); ++i) {
    gone_[i] = seen_through(map.votes()[i]) ? 1 : 0;
    if (gone_[i] != 0) open.push_back(i);
  }
  spread(open);
}

inline void Carving::spread(std::vector<std::uint32_t>& open) {
  for (std::size_t next = 0; next < open.size(); ++next)
    for_each_neighbour(open[next], [&](std::uint32_t i) {
      if (gone_[i] != 0 || seen(map_.votes()[i]) > CarveParams::kSpreadMaxSeen || !outnumbered(i)) return;
      gone_[i] = 1;
      open.push_back(i);
    });
}

inline bool Carving::outnumbered(std::uint32_t i) const {
  int all = 0, gone = 0;
  for_each_neighbour(i, [&](std::uint32_t j) {
    ++all;
    gone += gone_[j];
  });
  return gone > 0 && gone >= CarveParams::kSpreadShare * all;
}

template <class F>
void Carving::for_each_neighbour(std::uint32_t i, const F& f) const {
  const std::uint64_t key = map_.keys()[i];
  const std::int32_t x = VoxelKey::axis(key, 0), y = VoxelKey::axis(key, 1), z = VoxelKey::axis(key, 2);
  for (std::int32_t dz = -kReach; dz <= kReach; ++dz)
    for (std::int32_t dy = -kReach; dy <= kReach; ++dy)
      for (std::int32_t dx = -kReach; dx <= kReach; ++dx) {
        const std::uint32_t j = map_.find(VoxelKey::pack(x + dx, y + dy, z + dz, VoxelKey::label(key)));
        if (j != VoxelMap::kNone && j != i) f(j);
      }
}

}  // namespace dynfilter::mapping
