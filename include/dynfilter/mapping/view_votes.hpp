// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/mapping/depth_view.hpp>
#include <dynfilter/mapping/voxel_map.hpp>
#include <vector>

namespace dynfilter::mapping {

/// Adds (sign 1) or removes (-1) what a view says of the voxels from index `begin`: a surface seen, or seen through.
void add_votes(VoxelMap& map, const DepthView& view, const Pose& T_world_camera, std::size_t begin,
               double leaf_m, int sign);

/// Moves a view's votes to the permanent counters, from which nothing is removed.
void make_votes_permanent(VoxelMap& map, const DepthView& view, const Pose& T_world_camera, double leaf_m);

}  // namespace dynfilter::mapping

namespace dynfilter::mapping {

namespace detail {

inline void make_vote_permanent(std::uint16_t& live, std::uint16_t& old, int vote) {
  live = static_cast<std::uint16_t>(live - vote);
  old = static_cast<std::uint16_t>(std::min(65535, old + vote));
}

}  // namespace detail

inline void add_votes(VoxelMap& map, const DepthView& view, const Pose& T_world_camera, std::size_t begin,
                      double leaf_m, int sign) {
  std::vector<VoxelVotes>& votes = map.votes();
  view.visit(map.key_list(), begin, leaf_m, T_world_camera, [&](std::size_t i, int seen, int through) {
    votes[i].seen = static_cast<std::uint16_t>(votes[i].seen + sign * seen);
    votes[i].through = static_cast<std::uint16_t>(votes[i].through + sign * through);
  });
}

inline void make_votes_permanent(VoxelMap& map, const DepthView& view, const Pose& T_world_camera,
                                 double leaf_m) {
  std::vector<VoxelVotes>& votes = map.votes();
  view.visit(map.key_list(), 0, leaf_m, T_world_camera, [&](std::size_t i, int seen, int through) {
    detail::make_vote_permanent(votes[i].seen, votes[i].old_seen, seen);
    detail::make_vote_permanent(votes[i].through, votes[i].old_through, through);
  });
}

}  // namespace dynfilter::mapping
