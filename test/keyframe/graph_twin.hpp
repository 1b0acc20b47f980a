// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstdint>
#include <dynfilter/geometry/sampling.hpp>
#include <dynfilter/keyframe/graph.hpp>

namespace dynfilter_test {

using dynfilter::Graph;
using dynfilter::SampleGenerator;
using dynfilter::VertexSet;

inline Graph random_graph(SampleGenerator& rng, std::size_t n, double edge_share) {
  Graph graph(n);
  for (Graph::Vertex a = 0; a < n; ++a)
    for (Graph::Vertex b = a + 1; b < n; ++b)
      if (rng.uniform() < edge_share) graph.connect(a, b);
  return graph;
}

/// Frames along a path. Each shares points with nearby frames, like candidates of a moving camera.
inline Graph band_graph(SampleGenerator& rng, std::size_t n, std::size_t reach) {
  Graph graph(n);
  for (Graph::Vertex a = 0; a < n; ++a)
    for (Graph::Vertex b = a + 1; b < n && b <= a + reach; ++b)
      if (rng.uniform() < 0.8) graph.connect(a, b);
  return graph;
}

/// Size of the smallest cover, by testing every set of vertices; n <= 20.
inline std::size_t smallest_cover_by_trial(const Graph& graph) {
  const std::size_t n = graph.size();
  std::size_t best = n;
  for (std::uint32_t set = 0; set < (1U << n); ++set) {
    std::size_t size = 0;
    for (std::uint32_t rest = set; rest != 0; rest &= rest - 1) ++size;
    if (size >= best) continue;
    bool covers = true;
    for (Graph::Vertex a = 0; a < n && covers; ++a)
      if ((set >> a & 1U) == 0)
        for (const Graph::Vertex b : graph.neighbours(a)) covers = covers && (set >> b & 1U) != 0;
    if (covers) best = size;
  }
  return best;
}

/// True if b can be reached from a through vertices of `set`, in n steps.
inline bool reached(const Graph& graph, const VertexSet& set, Graph::Vertex a, Graph::Vertex b) {
  VertexSet at(graph.size(), 0);
  at[a] = 1;
  for (std::size_t step = 0; step < graph.size(); ++step)
    for (Graph::Vertex v = 0; v < graph.size(); ++v)
      if (at[v])
        for (const Graph::Vertex w : graph.neighbours(v))
          if (set[w]) at[w] = 1;
  return at[b] != 0;
}

}  // namespace dynfilter_test
