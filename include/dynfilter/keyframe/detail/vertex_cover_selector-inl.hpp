// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/keyframe/vertex_cover_selector.hpp>

#include <algorithm>
#include <dynfilter/core/frame_ids.hpp>
#include <dynfilter/core/inline.hpp>
#include <dynfilter/config/parameters.hpp>
#include <dynfilter/keyframe/bridges.hpp>
#include <dynfilter/keyframe/covisibility.hpp>
#include <limits>

namespace dynfilter {

DYNFILTER_INLINE const FieldTable<VertexCoverParams>& VertexCoverParams::fields() {
  using P = VertexCoverParams;
  constexpr int kMany = 1000000;
  static const FieldTable<P> table{
      real("min_translation_m", &P::min_translation_m, "m", {0, 1e9},
           "distance from the last candidate that makes a frame a candidate"),
      real("min_rotation_deg", &P::min_rotation_deg, "deg", {0, 180},
           "rotation from the last candidate that makes a frame a candidate"),
      integer("grid_columns", &P::grid_columns, "cells", {1, 1000},
              "columns of the image grid that measures the spread of features"),
      integer("grid_rows", &P::grid_rows, "cells", {1, 1000}, "rows of the image grid"),
      real("min_occupied_share", &P::min_occupied_share, "", {0, 1},
           "share of grid cells with features that makes a frame a candidate (the paper: evenly "
           "distributed)"),
      integer("min_spread_gap_frames", &P::min_spread_gap_frames, "frames", {1, kMany},
              "smallest gap between candidates that qualify by spread only (the paper: 1)"),
      integer("min_candidates", &P::min_candidates, "frames", {1, 2000},
              "number of candidates that are solved together"),
      integer("max_wait_frames", &P::max_wait_frames, "frames", {1, kMany},
              "longest wait of a candidate, after which a smaller batch is solved"),
      integer("min_shared_points", &P::min_shared_points, "", {1, kMany},
              "number of shared points that makes an edge"),
      real("min_shared_share", &P::min_shared_share, "", {0, 1},
           "smallest share of the points of the frame with fewer points for an edge (the paper: 0)"),
      flag("keep_isolated", &P::keep_isolated,
           "select frames without an edge, which no cover contains (the paper: false)"),
      integer("max_dynamic_features", &P::max_dynamic_features, "", {0, kMany},
              "number of dynamic features above which a keyframe is replaced by a cleaner neighbour or "
              "marked cut_dynamic")};
  return table;
}

DYNFILTER_INLINE VertexCoverSelector::VertexCoverSelector(const VertexCoverParams& params) : params_(params) {
  check_parameters(params_);
}

DYNFILTER_INLINE std::vector<SelectedFrame> VertexCoverSelector::flush() {
  const bool anything_new = fresh() < open_.size();
  std::vector<SelectedFrame> chosen = anything_new ? solve() : std::vector<SelectedFrame>();
  open_.clear();
  return chosen;
}

DYNFILTER_INLINE std::vector<std::int64_t> VertexCoverSelector::pending() const {
  std::vector<std::int64_t> ids;
  for (const Candidate& c : open_) ids.push_back(c.id);
  return ids;
}

DYNFILTER_INLINE std::vector<SelectedFrame> VertexCoverSelector::choose(const FrameSummary& frame) {
  if (is_candidate(frame)) {
    open_.push_back(
        {frame.id, frame.timestamp_s, sorted_points(frame.points), frame.dynamic_features, false});
    last_candidate_ = std::make_pair(frame.id, frame.T_world_camera);
  }
  const std::size_t first = fresh();
  if (first == open_.size()) return {};
  const bool enough = open_.size() - first >= static_cast<std::size_t>(params_.min_candidates);
  return enough || id_gap(frame.id, open_[first].id) >= params_.max_wait_frames
             ? solve()
             : std::vector<SelectedFrame>();
}

DYNFILTER_INLINE void VertexCoverSelector::forget() {
  open_.clear();
  anchor_.reset();
  last_candidate_.reset();
}

inline std::size_t VertexCoverSelector::fresh() const {
  std::size_t i = 0;
  while (i < open_.size() && open_[i].second_chance) ++i;
  return i;
}

inline bool VertexCoverSelector::is_candidate(const FrameSummary& frame) const {
  if (!last_candidate_) return true;
  const PoseDifference moved = difference(last_candidate_->second, frame.T_world_camera);
  if (moved.translation_m >= params_.min_translation_m || moved.rotation_deg >= params_.min_rotation_deg)
    return true;
  return id_gap(frame.id, last_candidate_->first) >= params_.min_spread_gap_frames &&
         occupied_share(frame, params_.grid_columns, params_.grid_rows) >= params_.min_occupied_share;
}

inline std::vector<const VertexCoverSelector::Candidate*> VertexCoverSelector::vertices() const {
  std::vector<const Candidate*> order;
  for (const Candidate& c : open_) order.push_back(&c);
  std::stable_sort(order.begin(), order.end(), [&](const Candidate* a, const Candidate* b) {
    return (dirty(*a) ? a->dynamic_features : 0) < (dirty(*b) ? b->dynamic_features : 0);
  });
  if (anchor_) order.push_back(&*anchor_);
  return order;
}

inline std::vector<SelectedFrame> VertexCoverSelector::solve() {
  const std::vector<const Candidate*> vertex = vertices();
  std::vector<const std::vector<std::int64_t>*> points;
  for (const Candidate* c : vertex) points.push_back(&c->points);
  const Graph graph = covisibility_graph(points, static_cast<std::size_t>(params_.min_shared_points),
                                         params_.min_shared_share);
  std::vector<std::optional<KeyframeReason>> why(vertex.size());
  VertexSet set = cover(graph, why);
  for (const Vertex b : add_bridges(graph, set)) why[b] = KeyframeReason::Bridge;
  replace_dirty(graph, vertex, set, why);
  return hand_over(vertex, set, why);
}

DYNFILTER_INLINE VertexSet VertexCoverSelector::cover(const Graph& graph,
                                                      std::vector<std::optional<KeyframeReason>>& why) {
  const std::size_t n = open_.size();
  Graph uncovered(graph.size());
  for (Vertex v = 0; v < n; ++v)
    for (const Vertex w : graph.neighbours(v))
      if (w < n) uncovered.connect(v, w);
  VertexSet set = small_vertex_cover(uncovered).set;
  for (Vertex v = 0; v < n; ++v) {
    if (set[v]) why[v] = KeyframeReason::Cover;
    if (graph.degree(v) > 0 || !params_.keep_isolated) continue;
    set[v] = 1, why[v] = KeyframeReason::Isolated;
  }
  if (anchor_) set[n] = 1;
  return set;
}

inline void VertexCoverSelector::replace_dirty(const Graph& graph,
                                               const std::vector<const Candidate*>& vertex, VertexSet& set,
                                               std::vector<std::optional<KeyframeReason>>& why) {
  for (Vertex v = 0; v < open_.size(); ++v) {
    if (!set[v] || !dirty(*vertex[v])) continue;
    const std::optional<Vertex> u = cleaner(graph, vertex, set, v);
    if (!u) continue;
    set[v] = 0, why[v].reset();
    set[*u] = 1, why[*u] = KeyframeReason::Replacement;
  }
}

inline std::optional<VertexCoverSelector::Vertex> VertexCoverSelector::cleaner(
    const Graph& graph, const std::vector<const Candidate*>& vertex, const VertexSet& set, Vertex v) const {
  std::optional<Vertex> best;
  std::size_t best_shared = 0;
  for (const Vertex u : graph.neighbours(v)) {
    if (set[u] || dirty(*vertex[u])) continue;
    VertexSet other = set;
    other[v] = 0, other[u] = 1;
    const std::size_t shared = shared_points(vertex[u]->points, vertex[v]->points);
    if (shared > best_shared && still_good(graph, other)) best = u, best_shared = shared;
  }
  return best;
}

inline std::vector<SelectedFrame> VertexCoverSelector::hand_over(
    const std::vector<const Candidate*>& vertex, const VertexSet& set,
    const std::vector<std::optional<KeyframeReason>>& why) {
  std::vector<SelectedFrame> chosen;
  const Candidate* last = nullptr;
  for (std::size_t v = 0; v < open_.size(); ++v) {
    if (!set[v]) continue;
    const Candidate& c = *vertex[v];
    chosen.push_back({c.id, c.timestamp_s, *why[v], dirty(c)});
    if (!last || c.id > last->id) last = &c;
  }
  std::sort(chosen.begin(), chosen.end(),
            [](const SelectedFrame& a, const SelectedFrame& b) { return a.id < b.id; });
  if (last) anchor_ = Candidate(*last);
  close(anchor_ ? anchor_->id : std::numeric_limits<std::int64_t>::min());
  return chosen;
}

inline void VertexCoverSelector::close(std::int64_t last_keyframe) {
  open_.erase(std::remove_if(open_.begin(), open_.end(),
                             [&](const Candidate& c) { return c.second_chance || c.id <= last_keyframe; }),
              open_.end());
  for (Candidate& c : open_) c.second_chance = true;
}

}  // namespace dynfilter
