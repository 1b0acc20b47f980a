// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <dynfilter/keyframe/graph.hpp>
#include <vector>

namespace dynfilter {

/// Connects two frames that share at least `min_shared` points.
/// They must also share at least `min_share` of the smaller point list.
/// The lists are ascending. Cost: n^2 merges.
Graph covisibility_graph(const std::vector<const std::vector<std::int64_t>*>& points, std::size_t min_shared,
                         double min_share = 0);

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/keyframe/detail/covisibility-inl.hpp>
#endif
