// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <dynfilter/keyframe/graph.hpp>

namespace dynfilter {

/// True if every edge has an end in `set`.
bool is_vertex_cover(const Graph& graph, const VertexSet& set);

/// Size of a maximal matching, a lower bound of every vertex cover.
/// A cover needs an end of each edge of the matching, and these edges share no ends.
std::size_t matching_bound(const Graph& graph);

/// A vertex cover. It is smallest if its size equals `lower_bound`.
struct VertexCover {
  VertexSet set;
  std::size_t size = 0;
  std::size_t lower_bound = 0;  ///< size of the smallest cover is at least this
  bool optimal() const { return size == lower_bound; }
};

/// A smallest vertex cover, or a small one if the search exceeds `max_steps`.
/// A step is one word operation; the limit is per connected component (1e7 takes about 10 ms).
/// First takes vertices by domination.
/// Then branches on the vertex of highest degree, bounded by a partition into cliques.
/// The first descent is the greedy cover, so a result always exists.
/// Ties prefer low numbers, so callers order vertices by preference. Deterministic.
VertexCover small_vertex_cover(const Graph& graph, std::uint64_t max_steps = 10000000);

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/keyframe/detail/vertex_cover-inl.hpp>
#endif
