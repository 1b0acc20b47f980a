// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/keyframe/pose_change.hpp>

#include <dynfilter/core/frame_ids.hpp>
#include <dynfilter/core/inline.hpp>
#include <dynfilter/config/parameters.hpp>
#include <utility>

namespace dynfilter {

DYNFILTER_INLINE const FieldTable<PoseChangeParams>& PoseChangeParams::fields() {
  using P = PoseChangeParams;
  static const FieldTable<P> table{
      real("min_translation_m", &P::min_translation_m, "m", {0, 1e9},
           "distance from the last keyframe that counts as motion"),
      real("min_rotation_deg", &P::min_rotation_deg, "deg", {0, 180},
           "rotation from the last keyframe that counts as motion"),
      flag("require_motion", &P::require_motion,
           "other criteria count only after motion; false: motion alone is a criterion"),
      integer("min_gap_frames", &P::min_gap_frames, "frames", {1, 1000000},
              "smallest gap between two keyframes"),
      integer("max_gap_frames", &P::max_gap_frames, "frames", {1, 1000000},
              "gap after which a frame becomes a keyframe"),
      real("min_shared_share", &P::min_shared_share, "", {0, 1},
           "share of the last keyframe's points below which a frame becomes a keyframe"),
      integer("max_dynamic_features", &P::max_dynamic_features, "", {0, 1000000},
              "number of dynamic features above which a keyframe is marked cut_dynamic")};
  return table;
}

DYNFILTER_INLINE PoseChangeSelector::PoseChangeSelector(const PoseChangeParams& params) : params_(params) {
  check_parameters(params_);
}

DYNFILTER_INLINE std::vector<SelectedFrame> PoseChangeSelector::choose(const FrameSummary& frame) {
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
                   params_.min_shared_share * static_cast<double>(last_->points.size());
  const bool late = gap >= params_.max_gap_frames;
  reason = far ? KeyframeReason::Moved : few ? KeyframeReason::FewShared : KeyframeReason::Gap;
  return params_.require_motion ? far && (few || late) : far || few || late;
}

}  // namespace dynfilter
