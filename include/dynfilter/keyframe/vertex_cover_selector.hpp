// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <dynfilter/config/field_table.hpp>
#include <dynfilter/config/parameters.hpp>
#include <dynfilter/core/limits.hpp>
#include <dynfilter/keyframe/frame_summary.hpp>
#include <dynfilter/keyframe/graph.hpp>
#include <dynfilter/keyframe/selector.hpp>
#include <dynfilter/keyframe/vertex_cover.hpp>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace dynfilter {

struct VertexCoverParams {
  double min_translation_m = 0.05;
  double min_rotation_deg = 5;
  static constexpr int kGridRows = 6;  ///< Rows of the image grid.
  /// Columns of the image grid that measures the spread of features.
  static constexpr int kGridColumns = 8;
  /// Share of grid cells with features that makes a frame a candidate (the paper: evenly distributed). Not a
  /// key: code sets it.
  double min_occupied_share = 0.7;
  /// Smallest gap between candidates that qualify by spread only (the paper: 1). Not a key: code sets it.
  int min_spread_gap_frames = 4;
  /// Number of candidates that are solved together. Not a key: code sets it.
  int min_candidates = 12;
  /// Longest wait of a candidate, after which a smaller batch is solved. Not a key: code sets it.
  int max_wait_frames = 150;
  /// Number of shared points that makes an edge. Not a key: code sets it.
  int min_shared_points = 15;
  /// Select frames without an edge, which no cover contains (the paper: false). Not a key: code sets it.
  bool keep_isolated = true;
  /// Number of dynamic features above which a keyframe is replaced by a cleaner neighbour or marked
  /// cut_dynamic. Not a key: code sets it.
  int max_dynamic_features = 300;

  static const FieldTable<VertexCoverParams>& fields() {
    using P = VertexCoverParams;
    static const FieldTable<P> table{real("min_translation_m", &P::min_translation_m, "m", {0, 1e9},
                                          "distance from the last candidate that makes a frame a candidate"),
                                     real("min_rotation_deg", &P::min_rotation_deg, "deg", {0, 180},
                                          "rotation from the last candidate that makes a frame a candidate")};
    return table;
  }
};

/// Keyframes as a small vertex cover of the covisibility graph of candidates (Zhou et al. sec. 3.2.1, after
/// KeySLAM). Of any two candidates that share enough points, at least one is selected. Selected frames are
/// connected where the candidates are. A frame with too many dynamic features is replaced by a cleaner one
/// with the same coverage. Batches are solved one after another. The last keyframe of a batch is part of the
/// next batch, already selected. If candidates are dense, all are covisible, and a cover contains nearly all
/// of them. The number of keyframes then depends on the choice of candidates.
class VertexCoverSelector final : public KeyframeSelector {
 public:
  static constexpr const char* kName = "vertex_cover";

  /// Throws ConfigError if a parameter is out of range.
  explicit VertexCoverSelector(const VertexCoverParams& params = VertexCoverParams()) : params_(params) {
    check_parameters(params_);
  }

  std::string name() const override { return kName; }

  std::vector<SelectedFrame> flush() override;

  std::vector<std::int64_t> pending() const override {
    std::vector<std::int64_t> ids;
    for (const Candidate& c : open_) ids.push_back(c.id);
    return ids;
  }

 protected:
  std::vector<SelectedFrame> choose(const FrameSummary& frame) override;
  void forget() override {
    open_.clear();
    anchor_.reset();
    last_candidate_.reset();
  }

 private:
  struct Candidate {
    std::int64_t id;
    double timestamp_s;
    std::vector<std::int64_t> points;
    int dynamic_features;
    bool second_chance = false;  ///< true if it was in the last batch
  };
  using Vertex = Graph::Vertex;

  /// Index of the first new candidate in `open_`.
  std::size_t fresh() const {
    std::size_t i = 0;
    while (i < open_.size() && open_[i].second_chance) ++i;
    return i;
  }

  bool is_candidate(const FrameSummary& frame) const;

  bool dirty(const Candidate& c) const { return c.dynamic_features > params_.max_dynamic_features; }

  /// Vertices of the batch. Clean frames are first, because the cover prefers low numbers.
  /// The anchor is last.
  std::vector<const Candidate*> vertices() const;

  std::vector<SelectedFrame> solve();

  /// The anchor is already selected, so its edges need no cover.
  VertexSet cover(const Graph& graph, std::vector<std::optional<KeyframeReason>>& why);

  bool is_connected_cover(const Graph& graph, const VertexSet& set) const {
    return is_vertex_cover(graph, set) && connected_within(graph, set);
  }

  void replace_dirty(const Graph& graph, const std::vector<const Candidate*>& vertex, VertexSet& set,
                     std::vector<std::optional<KeyframeReason>>& why);

  /// The clean neighbour that shares most points with v and can replace it in the cover.
  std::optional<Vertex> cleaner(const Graph& graph, const std::vector<const Candidate*>& vertex,
                                const VertexSet& set, Vertex v) const;

  std::vector<SelectedFrame> hand_over(const std::vector<const Candidate*>& vertex, const VertexSet& set,
                                       const std::vector<std::optional<KeyframeReason>>& why);

  void close(std::int64_t last_keyframe);

  VertexCoverParams params_;
  std::vector<Candidate> open_;
  std::optional<Candidate> anchor_;  ///< last keyframe of the previous batch
  std::optional<std::pair<std::int64_t, Pose>> last_candidate_;
};

inline std::vector<SelectedFrame> VertexCoverSelector::flush() {
  const bool anything_new = fresh() < open_.size();
  std::vector<SelectedFrame> chosen = anything_new ? solve() : std::vector<SelectedFrame>();
  open_.clear();
  return chosen;
}

inline std::vector<SelectedFrame> VertexCoverSelector::choose(const FrameSummary& frame) {
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

inline bool VertexCoverSelector::is_candidate(const FrameSummary& frame) const {
  if (!last_candidate_) return true;
  const PoseDifference moved = difference(last_candidate_->second, frame.T_world_camera);
  if (moved.translation_m >= params_.min_translation_m || moved.rotation_deg >= params_.min_rotation_deg)
    return true;
  return id_gap(frame.id, last_candidate_->first) >= params_.min_spread_gap_frames &&
         occupied_share(frame, VertexCoverParams::kGridColumns, VertexCoverParams::kGridRows) >=
             params_.min_occupied_share;
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
  const Graph graph = covisibility_graph(points, static_cast<std::size_t>(params_.min_shared_points));
  std::vector<std::optional<KeyframeReason>> why(vertex.size());
  VertexSet set = cover(graph, why);
  for (const Vertex b : add_bridges(graph, set)) why[b] = KeyframeReason::Bridge;
  replace_dirty(graph, vertex, set, why);
  return hand_over(vertex, set, why);
}

inline VertexSet VertexCoverSelector::cover(const Graph& graph,
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
    if (shared > best_shared && is_connected_cover(graph, other)) best = u, best_shared = shared;
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
