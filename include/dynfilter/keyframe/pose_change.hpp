// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <dynfilter/config/field_table.hpp>
#include <dynfilter/config/parameters.hpp>
#include <dynfilter/core/limits.hpp>
#include <dynfilter/keyframe/frame_summary.hpp>
#include <dynfilter/keyframe/selector.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace dynfilter {

struct PoseChangeParams {
  double min_translation_m = 0.10;
  double min_rotation_deg = 10;
  /// Other criteria count only after motion; false: motion alone is a criterion. Not a key: code sets it.
  bool require_motion = false;
  int min_gap_frames = 1;  ///< Smallest gap between two keyframes. Not a key: code sets it.
  int max_gap_frames = 20;
  /// Share of the last keyframe's points below which a frame becomes a keyframe.
  static constexpr double kMinSharedShare = 0.75;
  /// Number of dynamic features above which a keyframe is marked cut_dynamic. Not a key: code sets it.
  int max_dynamic_features = 300;

  static const FieldTable<PoseChangeParams>& fields() {
    using P = PoseChangeParams;
    static const FieldTable<P> table{real("min_translation_m", &P::min_translation_m, "m", {0, 1e9},
                                          "distance from the last keyframe that counts as motion"),
                                     real("min_rotation_deg", &P::min_rotation_deg, "deg", {0, 180},
                                          "rotation from the last keyframe that counts as motion"),
                                     integer("max_gap_frames", &P::max_gap_frames, "frames", {1, 1000000},
                                             "gap after which a frame becomes a keyframe")};
    return table;
  }
};

/// Keyframe selection of DeS-SLAM: relative pose to the last keyframe, and ORB-SLAM2's criteria.
/// The latter are frames since the last keyframe and the share of its points still visible.
/// The paper gives no thresholds and no rule to combine them. By default each criterion alone is sufficient.
/// With `require_motion` the other criteria count only after camera motion, which saves keyframes.
/// Decides immediately.
class PoseChangeSelector final : public KeyframeSelector {
 public:
  static constexpr const char* kName = "pose_change";

  /// Throws ConfigError if a parameter is out of range.
  explicit PoseChangeSelector(const PoseChangeParams& params = PoseChangeParams()) : params_(params) {
    check_parameters(params_);
  }

  std::string name() const override { return kName; }

 protected:
  std::vector<SelectedFrame> choose(const FrameSummary& frame) override;

  void forget() override { last_.reset(); }

 private:
  struct Last {
    std::int64_t id;
    Pose T_world_camera;
    std::vector<std::int64_t> points;
  };

  bool is_due(const FrameSummary& frame, const std::vector<std::int64_t>& points,
              KeyframeReason& reason) const;

  PoseChangeParams params_;
  std::optional<Last> last_;
};

inline std::vector<SelectedFrame> PoseChangeSelector::choose(const FrameSummary& frame) {
  std::vector<std::int64_t> points = sorted_points(frame.points);
  KeyframeReason reason = KeyframeReason::First;
  if (last_ && !is_due(frame, points, reason)) return {};
  last_ = Last{frame.id, frame.T_world_camera, std::move(points)};
  return {{frame.id, frame.timestamp_s, reason, frame.dynamic_features > params_.max_dynamic_features}};
}

inline bool PoseChangeSelector::is_due(const FrameSummary& frame, const std::vector<std::int64_t>& points,
                                       KeyframeReason& reason) const {
  const std::int64_t gap = id_gap(frame.id, last_->id);
  if (gap < params_.min_gap_frames) return false;
  const PoseDifference moved = difference(last_->T_world_camera, frame.T_world_camera);
  const bool far =
      moved.translation_m >= params_.min_translation_m || moved.rotation_deg >= params_.min_rotation_deg;
  const bool few = static_cast<double>(shared_points(last_->points, points)) <
                   PoseChangeParams::kMinSharedShare * static_cast<double>(last_->points.size());
  const bool late = gap >= params_.max_gap_frames;
  reason = far ? KeyframeReason::Moved : few ? KeyframeReason::FewShared : KeyframeReason::Gap;
  return params_.require_motion ? far && (few || late) : far || few || late;
}

}  // namespace dynfilter
