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

  explicit Graph(std::size_t vertices = 0) : neighbours_(vertices) {}

  std::size_t size() const { return neighbours_.size(); }
  std::size_t edges() const { return edges_; }
  std::size_t degree(Vertex v) const { return neighbours_[v].size(); }
  /// Ascending.
  const std::vector<Vertex>& neighbours(Vertex v) const { return neighbours_[v]; }

  bool connected(Vertex a, Vertex b) const {
    return std::binary_search(neighbours_[a].begin(), neighbours_[a].end(), b);
  }

  /// Ignores loops and existing edges.
  void connect(Vertex a, Vertex b);

 private:
  void insert(Vertex at, Vertex v);

  std::vector<std::vector<Vertex>> neighbours_;
  std::size_t edges_ = 0;
};

/// A set of vertices with one flag per vertex.
using VertexSet = std::vector<std::uint8_t>;

/// Number of vertices in the set.
inline std::size_t count(const VertexSet& set) {
  return static_cast<std::size_t>(std::count(set.begin(), set.end(), std::uint8_t{1}));
}

/// Component number of each vertex of `within`, in the order of the lowest vertices; -1 outside.
/// Linear.
std::vector<int> components(const Graph& graph, const VertexSet& within);

/// Component number of each vertex of the whole graph.
inline std::vector<int> components(const Graph& graph) {
  return components(graph, VertexSet(graph.size(), 1));
}

/// True if any two vertices of `set` that the graph connects are connected within `set`.
bool connected_within(const Graph& graph, const VertexSet& set);

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/keyframe/detail/graph-inl.hpp>
#endif
