// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/mapping/depth_view.hpp>
#include <dynfilter/mapping/voxel_map.hpp>

namespace dynfilter::mapping {

/// Adds (sign 1) or removes (-1) what a view says of the voxels from index `begin`: a surface seen, or seen through.
void add_votes(VoxelMap& map, const DepthView& view, const Pose& T_world_camera, std::size_t begin,
               double leaf_m, int sign);

/// Moves a view's votes to the permanent counters, from which nothing is removed.
void make_votes_permanent(VoxelMap& map, const DepthView& view, const Pose& T_world_camera, double leaf_m);

}  // namespace dynfilter::mapping

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/mapping/detail/view_votes-inl.hpp>
#endif
