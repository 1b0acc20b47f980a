// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/keyframe/graph.hpp>
#include <vector>

namespace dynfilter {

/// Adds vertices until any two vertices of `set` that the graph connects
/// are connected within `set`.
/// Uses shortest paths from the part with the lowest vertex of each component to the next part
/// (Zhou et al. sec. 3.2.1).
/// Returns the added vertices in order of addition.
std::vector<Graph::Vertex> add_bridges(const Graph& graph, VertexSet& set);

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/keyframe/detail/bridges-inl.hpp>
#endif
