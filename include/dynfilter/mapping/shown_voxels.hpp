// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <dynfilter/mapping/map_params.hpp>
#include <dynfilter/mapping/voxel_map.hpp>
#include <vector>

namespace dynfilter::mapping {

/// Indices of the voxels that a map shows, in key order.
struct ShownVoxels {
  std::vector<std::uint32_t> fine, coarse;
};

/// Without voxels that were seen through (Carving) and isolated ones (OutlierFilter).
/// Without coarse voxels where fine voxels of key objects exist.
ShownVoxels shown_voxels(const VoxelMap& map, const VoxelMap& key_map, const MappingParams& params);

}  // namespace dynfilter::mapping

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/mapping/detail/shown_voxels-inl.hpp>
#endif
