// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <dynfilter/keyframe/graph.hpp>
#include <vector>

namespace dynfilter {

/// Adds vertices until any two vertices of `set` that the graph connects
/// are connected within `set`.
/// Uses shortest paths from the part with the lowest vertex of each component to the next part
/// (Zhou et al. sec. 3.2.1).
/// Returns the added vertices in order of addition.
std::vector<Graph::Vertex> add_bridges(const Graph& graph, VertexSet& set);

namespace detail {

/// The vertices between part `from` of `set` and the nearest other part.
/// Breadth-first search through the rest of the graph. Empty if no path exists.
inline std::vector<Graph::Vertex> way_to_another_part(const Graph& graph, const std::vector<int>& part,
                                                      int from) {
  constexpr Graph::Vertex kNone = ~Graph::Vertex{0};
  std::vector<Graph::Vertex> open, parent(graph.size(), kNone);
  VertexSet seen(graph.size(), 0);
  for (Graph::Vertex v = 0; v < graph.size(); ++v)
    if (part[v] == from) seen[v] = 1, open.push_back(v);
  for (std::size_t i = 0; i < open.size(); ++i) {
    const Graph::Vertex v = open[i];
    for (const Graph::Vertex w : graph.neighbours(v)) {
      if (seen[w]) continue;
      if (part[w] >= 0) {
        std::vector<Graph::Vertex> way;
        for (Graph::Vertex b = v; part[b] < 0; b = parent[b]) way.push_back(b);
        return way;
      }
      seen[w] = 1;
      parent[w] = v;
      open.push_back(w);
    }
  }
  return {};
}

}  // namespace detail

inline std::vector<Graph::Vertex> add_bridges(const Graph& graph, VertexSet& set) {
  std::vector<Graph::Vertex> bridges;
  for (bool joined = true; joined;) {
    joined = false;
    const std::vector<int> part = components(graph, set);
    int next = 0;
    for (Graph::Vertex v = 0; v < graph.size() && !joined; ++v) {
      if (part[v] != next) continue;
      const std::vector<Graph::Vertex> way = detail::way_to_another_part(graph, part, next++);
      for (const Graph::Vertex b : way) set[b] = 1, bridges.push_back(b);
      joined = !way.empty();
    }
  }
  return bridges;
}

}  // namespace dynfilter
