// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <dynfilter/core/error.hpp>
#include <dynfilter/config/field_table.hpp>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/keyframe/frame_summary.hpp>
#include <dynfilter/keyframe/graph.hpp>
#include <dynfilter/keyframe/selector.hpp>
#include <dynfilter/keyframe/vertex_cover.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace dynfilter {

struct VertexCoverParams {
  double min_translation_m = 0.05;
  double min_rotation_deg = 5;
  int grid_columns = 8, grid_rows = 6;
  double min_occupied_share = 0.7;
  int min_spread_gap_frames = 4;
  int min_candidates = 12;
  int max_wait_frames = 150;
  int min_shared_points = 15;
  double min_shared_share = 0;
  bool keep_isolated = true;
  int max_dynamic_features = 300;

  static const FieldTable<VertexCoverParams>& fields();
};

/// Keyframes as a small vertex cover of the covisibility graph of candidates
/// (Zhou et al. sec. 3.2.1, after KeySLAM).
/// Of any two candidates that share enough points, at least one is selected.
/// Selected frames are connected where the candidates are.
/// A frame with too many dynamic features is replaced by a cleaner one with the same coverage.
/// Batches are solved one after another.
/// The last keyframe of a batch is part of the next batch, already selected.
/// If candidates are dense, all are covisible, and a cover contains nearly all of them.
/// The number of keyframes then depends on the choice of candidates.
class VertexCoverSelector final : public KeyframeSelector {
 public:
  static constexpr const char* kName = "vertex_cover";

  /// Throws ConfigError if a parameter is out of range.
  explicit VertexCoverSelector(const VertexCoverParams& params = VertexCoverParams());

  std::string name() const override { return kName; }

  std::vector<SelectedFrame> flush() override;

  std::vector<std::int64_t> pending() const override;

 protected:
  std::vector<SelectedFrame> choose(const FrameSummary& frame) override;

  void forget() override;

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
  std::size_t fresh() const;

  bool is_candidate(const FrameSummary& frame) const;

  bool dirty(const Candidate& c) const { return c.dynamic_features > params_.max_dynamic_features; }

  /// Vertices of the batch. Clean frames are first, because the cover prefers low numbers.
  /// The anchor is last.
  std::vector<const Candidate*> vertices() const;

  std::vector<SelectedFrame> solve();

  /// The anchor is already selected, so its edges need no cover.
  VertexSet cover(const Graph& graph, std::vector<std::optional<KeyframeReason>>& why);

  bool still_good(const Graph& graph, const VertexSet& set) const {
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

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/keyframe/detail/vertex_cover_selector-inl.hpp>
#endif
