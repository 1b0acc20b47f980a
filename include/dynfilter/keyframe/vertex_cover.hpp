// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <bitset>
#include <cstddef>
#include <cstdint>
#include <dynfilter/keyframe/graph.hpp>
#include <utility>
#include <vector>

namespace dynfilter {

/// A vertex cover. It is smallest if its size equals `lower_bound`.
struct VertexCover {
  VertexSet set;
  std::size_t size = 0;
  std::size_t lower_bound = 0;                          ///< size of the smallest cover is at least this
  bool optimal() const { return size == lower_bound; }  ///< whether it is certainly a smallest one
};

/// True if every edge has an end in `set`.
inline bool is_vertex_cover(const Graph& graph, const VertexSet& set) {
  for (Graph::Vertex v = 0; v < graph.size(); ++v) {
    if (set[v]) continue;
    for (const Graph::Vertex w : graph.neighbours(v))
      if (!set[w]) return false;
  }
  return true;
}

namespace detail {

/// Branch and bound on one connected graph with rows of bits.
class CoverSearch {
 public:
  CoverSearch(const Graph& graph, const std::vector<Graph::Vertex>& vertices, std::uint64_t max_steps)
      : n_(vertices.size()), words_((n_ + 63) / 64), max_steps_(max_steps), rows_(n_ * words_, 0) {
    std::vector<std::size_t> place(graph.size(), n_);
    for (std::size_t i = 0; i < n_; ++i) place[vertices[i]] = i;
    for (std::size_t i = 0; i < n_; ++i)
      for (const Graph::Vertex w : graph.neighbours(vertices[i])) set(row(i), place[w]);
  }

  /// The selected vertices, by index in `vertices`. `lower_bound` is their number if the search completed.
  std::vector<std::size_t> run(std::size_t& lower_bound) {
    State root{Bits(words_, 0), {}};
    for (std::size_t i = 0; i < n_; ++i) set(root.alive.data(), i);
    best_size_ = n_ + 1;
    lower_bound = clique_bound(root.alive);
    descend(std::move(root));
    if (!out_of_steps_) lower_bound = best_size_;
    return best_;
  }

 private:
  using Word = std::uint64_t;
  using Bits = std::vector<Word>;
  struct State {
    Bits alive;
    std::vector<std::size_t> chosen;
  };

  Word* row(std::size_t i) { return rows_.data() + i * words_; }
  const Word* row(std::size_t i) const { return rows_.data() + i * words_; }
  static void set(Word* bits, std::size_t i) { bits[i / 64] |= Word{1} << i % 64; }
  static void clear(Word* bits, std::size_t i) { bits[i / 64] &= ~(Word{1} << i % 64); }
  static bool has(const Word* bits, std::size_t i) { return (bits[i / 64] >> i % 64 & 1) != 0; }

  std::size_t degree(const Bits& alive, std::size_t v) const {
    std::size_t sum = 0;
    for (std::size_t k = 0; k < words_; ++k) sum += std::bitset<64>(row(v)[k] & alive[k]).count();
    return sum;
  }

  static void take(State& state, std::size_t v) {
    state.chosen.push_back(v);
    clear(state.alive.data(), v);
  }

  /// True if all remaining neighbours of u are v or neighbours of v.
  bool dominated(const Bits& alive, std::size_t u, std::size_t v) {
    steps_ += words_;
    for (std::size_t k = 0; k < words_; ++k) {
      Word beyond = row(u)[k] & alive[k] & ~row(v)[k];
      if (v / 64 == k) beyond &= ~(Word{1} << v % 64);
      if (beyond != 0) return false;
    }
    return true;
  }

  /// Takes v if it dominates a neighbour u, because some smallest cover contains v.
  /// This includes every u of degree one.
  bool take_if_dominating(State& state, std::size_t v) {
    for (std::size_t u = n_; u-- > 0;) {
      if (!has(state.alive.data(), u) || !has(row(v), u) || !dominated(state.alive, u, v)) continue;
      take(state, v);
      return true;
    }
    return false;
  }

  void reduce(State& state) {
    for (bool changed = true; changed;) {
      changed = false;
      for (std::size_t v = 0; v < n_; ++v) {
        if (!has(state.alive.data(), v)) continue;
        if (degree(state.alive, v) == 0)
          clear(state.alive.data(), v);
        else
          changed = take_if_dominating(state, v) || changed;
      }
    }
  }

  /// Number of vertices minus the number of cliques in a partition.
  /// A cover omits at most one vertex of each clique.
  std::size_t clique_bound(const Bits& alive) {
    std::vector<Bits> common;  // common neighbours of each clique
    std::size_t vertices = 0;
    for (std::size_t v = 0; v < n_; ++v) {
      if (!has(alive.data(), v)) continue;
      ++vertices;
      steps_ += common.size() + words_;
      auto clique =
          std::find_if(common.begin(), common.end(), [&](const Bits& c) { return has(c.data(), v); });
      if (clique == common.end()) clique = common.insert(clique, Bits(words_, ~Word{0}));
      for (std::size_t k = 0; k < words_; ++k) (*clique)[k] &= row(v)[k];
    }
    return vertices - common.size();
  }

  std::size_t widest(const Bits& alive) const {
    std::size_t best = n_, best_degree = 0;
    for (std::size_t v = 0; v < n_; ++v) {
      if (!has(alive.data(), v)) continue;
      const std::size_t d = degree(alive, v);
      if (d > best_degree) best = v, best_degree = d;
    }
    return best;
  }

  void descend(State state) {
    if (best_size_ <= n_ && steps_ > max_steps_) out_of_steps_ = true;
    if (out_of_steps_) return;
    reduce(state);
    if (state.chosen.size() + clique_bound(state.alive) >= best_size_) return;
    const std::size_t v = widest(state.alive);
    if (v == n_) {
      best_ = state.chosen;
      best_size_ = best_.size();
      return;
    }
    State with = state;
    take(with, v);
    descend(std::move(with));
    for (std::size_t w = 0; w < n_; ++w)
      if (has(state.alive.data(), w) && has(row(v), w)) take(state, w);
    descend(std::move(state));
  }

  std::size_t n_, words_;
  std::uint64_t max_steps_, steps_ = 0;
  Bits rows_;
  std::vector<std::size_t> best_;
  std::size_t best_size_ = 0;
  bool out_of_steps_ = false;
};

}  // namespace detail

/// A smallest vertex cover, or a small one if the search exceeds `max_steps`. A step is one word operation;
/// the limit is per connected component (1e7 takes about 10 ms). First takes vertices by domination. Then
/// branches on the vertex of highest degree, bounded by a partition into cliques. The first descent is the
/// greedy cover, so a result always exists. Ties: the low number wins, so order by preference.
inline VertexCover small_vertex_cover(const Graph& graph, std::uint64_t max_steps = 10000000) {
  VertexCover cover;
  cover.set.assign(graph.size(), 0);
  const std::vector<int> component = components(graph);
  std::vector<std::vector<Graph::Vertex>> members;
  for (Graph::Vertex v = 0; v < graph.size(); ++v) {
    const auto c = static_cast<std::size_t>(component[v]);
    if (c >= members.size()) members.resize(c + 1);
    members[c].push_back(v);
  }
  for (const std::vector<Graph::Vertex>& vertices : members) {
    if (vertices.size() < 2) continue;
    std::size_t bound = 0;
    for (const std::size_t i : detail::CoverSearch(graph, vertices, max_steps).run(bound))
      cover.set[vertices[i]] = 1;
    cover.lower_bound += bound;
  }
  cover.size = count(cover.set);
  return cover;
}

}  // namespace dynfilter
