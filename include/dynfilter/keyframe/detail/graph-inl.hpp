// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/keyframe/graph.hpp>

#include <dynfilter/core/inline.hpp>

namespace dynfilter {

DYNFILTER_INLINE void Graph::connect(Vertex a, Vertex b) {
  if (a == b || connected(a, b)) return;
  insert(a, b);
  insert(b, a);
  ++edges_;
}

inline void Graph::insert(Vertex at, Vertex v) {
  std::vector<Vertex>& list = neighbours_[at];
  list.insert(std::lower_bound(list.begin(), list.end(), v), v);
}

DYNFILTER_INLINE std::vector<int> components(const Graph& graph, const VertexSet& within) {
  std::vector<int> component(graph.size(), -1);
  std::vector<Graph::Vertex> open;
  int found = 0;
  for (Graph::Vertex start = 0; start < graph.size(); ++start) {
    if (!within[start] || component[start] >= 0) continue;
    component[start] = found;
    open.assign(1, start);
    while (!open.empty()) {
      const Graph::Vertex v = open.back();
      open.pop_back();
      for (const Graph::Vertex w : graph.neighbours(v)) {
        if (!within[w] || component[w] >= 0) continue;
        component[w] = found;
        open.push_back(w);
      }
    }
    ++found;
  }
  return component;
}

DYNFILTER_INLINE bool connected_within(const Graph& graph, const VertexSet& set) {
  const std::vector<int> whole = components(graph), inside = components(graph, set);
  std::vector<int> seen(graph.size(), -1);
  for (Graph::Vertex v = 0; v < graph.size(); ++v) {
    if (!set[v]) continue;
    int& first = seen[static_cast<std::size_t>(whole[v])];
    if (first >= 0 && first != inside[v]) return false;
    first = inside[v];
  }
  return true;
}

}  // namespace dynfilter
