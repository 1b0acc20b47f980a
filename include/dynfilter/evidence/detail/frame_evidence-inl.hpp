// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/evidence/frame_evidence.hpp>

#include <dynfilter/core/inline.hpp>
#include <dynfilter/config/parameters.hpp>
#include <dynfilter/evidence/history.hpp>

namespace dynfilter {

DYNFILTER_INLINE FrameEvidence::FrameEvidence(const CorrespondenceParams& params)
    : params_(checked(params)),
      current_(params.max_depth_m, params.max_depth_edge),
      matches_(params_, current_),
      models_(current_),
      tracks_(current_, matches_),
      late_(current_, matches_) {}

DYNFILTER_INLINE void FrameEvidence::begin(const FrameView& frame, CallPoint call_point) {
  call_point_ = call_point;
  current_.begin(frame);
  stages_.begin(current_.pixels());
  models_.begin();
  late_.begin(matches_.begin());
}

DYNFILTER_INLINE void FrameEvidence::end(bool keyframe) {
  late_.end();
  if (keyframe) matches_.history().mark_keyframe();
  current_.end();
}

DYNFILTER_INLINE void FrameEvidence::reset() {
  matches_.reset();
  tracks_.reset();
  late_.reset();
}

DYNFILTER_INLINE void FrameEvidence::update_pose(std::int64_t frame_id, const Pose& T_world_camera,
                                                 PoseProvenance provenance) {
  StoredFrame* stored = matches_.history().find(frame_id);
  if (stored == nullptr || !is_rigid(T_world_camera)) return;
  stored->T_world_camera = T_world_camera;
  stored->pose_provenance = provenance;
}

DYNFILTER_INLINE void FrameEvidence::collect_seeds(const Match& match, bool all,
                                                   std::vector<int>& seeds) const {
  seeds.clear();
  const Span<const std::uint8_t> seed = stages_.seed();
  for (std::size_t i = 0; i < size(); ++i)
    if (match.found(i) && (all || seed[i] != 0)) seeds.push_back(static_cast<int>(i));
}

DYNFILTER_INLINE std::optional<Pose> FrameEvidence::host_motion(const Match& match) const {
  const FrameView& now = frame();
  if (match.reference == nullptr || now.pose_provenance == PoseProvenance::None ||
      match.reference->pose_provenance == PoseProvenance::None)
    return std::nullopt;
  return inverse(now.T_world_camera) * match.reference->T_world_camera;
}

inline const CorrespondenceParams& FrameEvidence::checked(const CorrespondenceParams& params) {
  check_parameters(params, "correspondence");
  return params;
}

}  // namespace dynfilter
