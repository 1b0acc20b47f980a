// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <dynfilter/mapping/map_params.hpp>
#include <dynfilter/mapping/voxel_map.hpp>
#include <vector>

namespace dynfilter::mapping {

/// The voxels of a map that free space removes.
/// First, voxels that enough keyframes saw through are removed (CarveParams).
/// Then the removal spreads to the remains of the same object.
/// A person who left is mostly seen through, except in front of pixels without depth.
/// A voxel is also removed if at most `spread_max_seen` keyframes saw it
/// and at least `spread_share` of its neighbours within two cells are removed.
/// This repeats until nothing changes.
/// The result does not depend on the order, because a removal only favours further removals.
class Carving {
 public:
  /// Neighbours have the same class.
  /// Cost: one test per voxel, and 124 look-ups per voxel that few keyframes saw
  /// and that has a removed neighbour.
  Carving(const VoxelMap& map, const CarveParams& params);

  bool gone(std::size_t i) const { return gone_[i] != 0; }

 private:
  static int seen(const VoxelVotes& v) { return v.seen + v.old_seen; }
  bool seen_through(const VoxelVotes& v) const;

  void spread(std::vector<std::uint32_t>& open);
  bool outnumbered(std::uint32_t i) const;
  template <class F>
  void for_each_neighbour(std::uint32_t i, const F& f) const;

  static constexpr std::int32_t kReach = 2;
  const VoxelMap& map_;
  CarveParams params_;
  std::vector<std::uint8_t> gone_;
};

}  // namespace dynfilter::mapping

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/mapping/detail/carving-inl.hpp>
#endif
