// SPDX-License-Identifier: MIT
#include <dynfilter/keyframe/graph.hpp>
#include <dynfilter/keyframe/vertex_cover.hpp>

#include "doctest/doctest.h"
#include "graph_twin.hpp"

namespace vertex_cover_test {

using namespace dynfilter;
using namespace dynfilter_test;

namespace {

/// Size of a maximal matching, a lower bound of every vertex cover.
/// A cover needs an end of each edge of the matching, and these edges share no ends.
std::size_t matching_bound(const Graph& graph) {
  VertexSet matched(graph.size(), 0);
  std::size_t edges = 0;
  for (Graph::Vertex v = 0; v < graph.size(); ++v) {
    if (matched[v]) continue;
    for (const Graph::Vertex w : graph.neighbours(v)) {
      if (matched[w]) continue;
      matched[v] = matched[w] = 1;
      ++edges;
      break;
    }
  }
  return edges;
}

Graph path(std::size_t n) {
  Graph graph(n);
  for (Graph::Vertex v = 1; v < n; ++v) graph.connect(v - 1, v);
  return graph;
}

Graph cycle(std::size_t n) {
  Graph graph = path(n);
  graph.connect(static_cast<Graph::Vertex>(n - 1), 0);
  return graph;
}

Graph star(std::size_t leaves) {
  Graph graph(leaves + 1);
  for (Graph::Vertex v = 0; v < leaves; ++v) graph.connect(v, static_cast<Graph::Vertex>(leaves));
  return graph;
}

Graph complete(std::size_t n) {
  Graph graph(n);
  for (Graph::Vertex a = 0; a < n; ++a)
    for (Graph::Vertex b = a + 1; b < n; ++b) graph.connect(a, b);
  return graph;
}

Graph bipartite(std::size_t left, std::size_t right) {
  Graph graph(left + right);
  for (Graph::Vertex a = 0; a < left; ++a)
    for (Graph::Vertex b = 0; b < right; ++b) graph.connect(a, static_cast<Graph::Vertex>(left + b));
  return graph;
}

Graph petersen() {
  Graph graph(10);
  for (Graph::Vertex v = 0; v < 5; ++v) {
    graph.connect(v, (v + 1) % 5);
    graph.connect(v, v + 5);
    graph.connect(v + 5, (v + 2) % 5 + 5);
  }
  return graph;
}

std::size_t cover_size(const Graph& graph) {
  const VertexCover cover = small_vertex_cover(graph);
  CHECK(is_vertex_cover(graph, cover.set));
  CHECK(cover.optimal());
  return cover.size;
}

}  // namespace

TEST_CASE("a graph keeps each edge once and no loops") {
  Graph graph(3);
  graph.connect(0, 1);
  graph.connect(1, 0);
  graph.connect(2, 2);
  CHECK(graph.edges() == 1);
  CHECK(graph.connected(1, 0));
  CHECK_FALSE(graph.connected(2, 2));
  CHECK(components(graph) == std::vector<int>{0, 0, 1});
}

TEST_CASE("smallest covers that are known") {
  CHECK(cover_size(Graph(0)) == 0);
  CHECK(cover_size(Graph(4)) == 0);
  CHECK(cover_size(star(9)) == 1);
  CHECK(cover_size(petersen()) == 6);
  for (std::size_t n = 2; n < 12; ++n) {
    CAPTURE(n);
    CHECK(cover_size(path(n)) == n / 2);
    CHECK(cover_size(complete(n)) == n - 1);
    if (n > 2) CHECK(cover_size(cycle(n)) == (n + 1) / 2);
    CHECK(cover_size(bipartite(n, 4)) == std::min<std::size_t>(n, 4));
  }
  CHECK(cover_size(path(501)) == 250);
  CHECK(cover_size(cycle(301)) == 151);
  CHECK(small_vertex_cover(star(9)).set[9] == 1);
}

TEST_CASE("among equals low numbers are taken") {
  const VertexCover cover = small_vertex_cover(complete(5));
  CHECK(cover.set == VertexSet{1, 1, 1, 1, 0});
}

TEST_CASE("the cover is as small as trying every set finds it, and its bound holds") {
  SampleGenerator rng(1);
  for (int trial = 0; trial < 150; ++trial) {
    const Graph graph = random_graph(rng, 3 + rng.below(12), rng.uniform(0.05, 0.9));
    const VertexCover cover = small_vertex_cover(graph);
    const std::size_t smallest = smallest_cover_by_trial(graph);
    CAPTURE(trial);
    REQUIRE(is_vertex_cover(graph, cover.set));
    CHECK(cover.size == smallest);
    CHECK(count(cover.set) == cover.size);
    CHECK(matching_bound(graph) <= smallest);
    // With no steps left, the result is still a cover and the bound is valid.
    const VertexCover hasty = small_vertex_cover(graph, 0);
    CHECK(is_vertex_cover(graph, hasty.set));
    CHECK(hasty.size >= smallest);
    CHECK(hasty.lower_bound <= smallest);
  }
}

TEST_CASE("graphs as a moving camera makes them are solved exactly") {
  SampleGenerator rng(2);
  for (const std::size_t n : {30, 60, 120}) {
    const VertexCover cover = small_vertex_cover(band_graph(rng, n, 8));
    CHECK(cover.optimal());
    CHECK(cover.size < n);
  }
}

TEST_CASE("how far the greedy cover is from the smallest" * doctest::test_suite("measure")) {
  SampleGenerator rng(3);
  double greedy = 0, exact = 0, matching = 0;
  std::size_t hit = 0, trials = 400;
  for (std::size_t trial = 0; trial < trials; ++trial) {
    const Graph graph = random_graph(rng, 14, rng.uniform(0.1, 0.7));
    const VertexCover hasty = small_vertex_cover(graph, 0), best = small_vertex_cover(graph);
    greedy += static_cast<double>(hasty.size), exact += static_cast<double>(best.size);
    matching += static_cast<double>(matching_bound(graph));
    hit += hasty.size == best.size ? 1 : 0;
  }
  MESSAGE("14 vertices: greedy / smallest " << greedy / exact << ", smallest in " << hit << " of " << trials
                                            << ", matching bound / smallest " << matching / exact);
  for (const std::size_t n : {50, 100, 200}) {
    const VertexCover cover = small_vertex_cover(random_graph(rng, n, 0.1));
    MESSAGE(n << " vertices, a tenth of the edges: " << cover.size << ", no cover below "
              << cover.lower_bound);
  }
  CHECK(greedy >= exact);
}

TEST_CASE("bridges join the parts of a set along shortest ways") {
  const Graph graph = path(9);
  VertexSet set{1, 0, 1, 0, 0, 0, 1, 0, 0};
  const std::vector<Graph::Vertex> bridges = add_bridges(graph, set);
  CHECK(count(set) == 3 + bridges.size());
  CHECK(set == VertexSet{1, 1, 1, 1, 1, 1, 1, 0, 0});
  CHECK(add_bridges(graph, set).empty());
}

TEST_CASE("bridges take the short way round a cycle and leave apart what the graph leaves apart") {
  Graph graph = cycle(8);
  VertexSet set(8, 0);
  set[0] = set[3] = 1;
  CHECK(add_bridges(graph, set).size() == 2);
  CHECK(set == VertexSet{1, 1, 1, 1, 0, 0, 0, 0});

  Graph apart(6);
  apart.connect(0, 1);
  apart.connect(1, 2);
  apart.connect(3, 4);
  VertexSet both{1, 0, 1, 1, 0, 1};
  CHECK(add_bridges(apart, both) == std::vector<Graph::Vertex>{1});
  CHECK(connected_within(apart, both));
}

TEST_CASE("with bridges a cover is connected wherever the graph is") {
  SampleGenerator rng(4);
  for (int trial = 0; trial < 60; ++trial) {
    const Graph graph = random_graph(rng, 12, rng.uniform(0.05, 0.4));
    VertexSet set = small_vertex_cover(graph).set;
    const VertexSet all(graph.size(), 1);
    add_bridges(graph, set);
    CAPTURE(trial);
    CHECK(is_vertex_cover(graph, set));
    CHECK(connected_within(graph, set));
    for (Graph::Vertex a = 0; a < graph.size(); ++a)
      for (Graph::Vertex b = 0; b < a; ++b)
        if (set[a] && set[b]) CHECK(reached(graph, set, a, b) == reached(graph, all, a, b));
  }
}

}  // namespace vertex_cover_test
