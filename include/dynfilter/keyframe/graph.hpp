// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace dynfilter {

/// An undirected graph on vertices 0 .. size() - 1 without loops and multiple edges.
class Graph {
 public:
  using Vertex = std::uint32_t;

  explicit Graph(std::size_t vertices = 0) : neighbours_(vertices) {}  ///< without edges

  std::size_t size() const { return neighbours_.size(); }
  std::size_t edges() const { return edges_; }                          ///< number of edges
  std::size_t degree(Vertex v) const { return neighbours_[v].size(); }  ///< number of edges at v
  /// Ascending.
  const std::vector<Vertex>& neighbours(Vertex v) const { return neighbours_[v]; }

  /// Whether there is an edge.
  bool connected(Vertex a, Vertex b) const {
    return std::binary_search(neighbours_[a].begin(), neighbours_[a].end(), b);
  }

  /// Ignores loops and existing edges.
  void connect(Vertex a, Vertex b);

 private:
  void insert(Vertex at, Vertex v) {
    std::vector<Vertex>& list = neighbours_[at];
    list.insert(std::lower_bound(list.begin(), list.end(), v), v);
  }

  std::vector<std::vector<Vertex>> neighbours_;
  std::size_t edges_ = 0;
};

/// A set of vertices with one flag per vertex.
using VertexSet = std::vector<std::uint8_t>;

/// Number of vertices in the set.
inline std::size_t count(const VertexSet& set) {
  return static_cast<std::size_t>(std::count(set.begin(), set.end(), std::uint8_t{1}));
}

inline void Graph::connect(Vertex a, Vertex b) {
  if (a == b || connected(a, b)) return;
  insert(a, b);
  insert(b, a);
  ++edges_;
}

/// Component number of each vertex of `within`, in the order of the lowest vertices; -1 outside. Linear.
inline std::vector<int> components(const Graph& graph, const VertexSet& within) {
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

/// Component number of each vertex of the whole graph.
inline std::vector<int> components(const Graph& graph) {
  return components(graph, VertexSet(graph.size(), 1));
}

/// True if any two vertices of `set` that the graph connects are connected within `set`.
inline bool connected_within(const Graph& graph, const VertexSet& set) {
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

/// Adds vertices until any two vertices of `set` that the graph connects are connected within `set`.
/// Uses shortest paths from the part with the lowest vertex of each component to the next part (Zhou et al.
/// sec. 3.2.1). Returns the added vertices in order of addition.
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
