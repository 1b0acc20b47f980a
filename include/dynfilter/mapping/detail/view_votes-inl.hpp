// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/mapping/view_votes.hpp>

#include <algorithm>
#include <cstdint>
#include <dynfilter/core/inline.hpp>
#include <vector>

namespace dynfilter::mapping {

namespace detail {

inline void make_vote_permanent(std::uint16_t& live, std::uint16_t& old, int vote) {
  live = static_cast<std::uint16_t>(live - vote);
  old = static_cast<std::uint16_t>(std::min(65535, old + vote));
}

}  // namespace detail

DYNFILTER_INLINE void add_votes(VoxelMap& map, const DepthView& view, const Pose& T_world_camera,
                                std::size_t begin, double leaf_m, int sign) {
  std::vector<VoxelVotes>& votes = map.votes();
  view.visit(map.key_list(), begin, leaf_m, T_world_camera, [&](std::size_t i, int seen, int through) {
    votes[i].seen = static_cast<std::uint16_t>(votes[i].seen + sign * seen);
    votes[i].through = static_cast<std::uint16_t>(votes[i].through + sign * through);
  });
}

DYNFILTER_INLINE void make_votes_permanent(VoxelMap& map, const DepthView& view, const Pose& T_world_camera,
                                           double leaf_m) {
  std::vector<VoxelVotes>& votes = map.votes();
  view.visit(map.key_list(), 0, leaf_m, T_world_camera, [&](std::size_t i, int seen, int through) {
    detail::make_vote_permanent(votes[i].seen, votes[i].old_seen, seen);
    detail::make_vote_permanent(votes[i].through, votes[i].old_through, through);
  });
}

}  // namespace dynfilter::mapping
