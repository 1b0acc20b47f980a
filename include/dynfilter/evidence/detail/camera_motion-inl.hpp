// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/evidence/camera_motion.hpp>

#include <dynfilter/core/inline.hpp>
#include <dynfilter/core/pose.hpp>
#include <string>

namespace dynfilter {

namespace detail {

/// Fits on the seeds, or on all features if the seeds give no motion.
inline std::optional<RigidMotion> fitted_motion(const Evidence& evidence, const Match& match, Votes& votes,
                                                std::vector<int>& seeds) {
  for (const bool all : {false, true}) {
    evidence.collect_seeds(match, all, seeds);
    const RigidMotion& motion = evidence.rigid_motion(match, seeds);
    if (!motion.ok) {
      if (all) votes.note("motion: none, ", to_string(motion.note));
      continue;
    }
    votes.note("motion: ", motion.inliers, " of ", motion.points,
               all ? " features (too few seeds)" : " seeds");
    return motion;
  }
  return std::nullopt;
}

}  // namespace detail

DYNFILTER_INLINE std::optional<RigidMotion> camera_motion(const Evidence& evidence, const Match& match,
                                                          MotionSource source, Votes& votes,
                                                          std::vector<int>& seeds) {
  if (source == MotionSource::Seeds) return detail::fitted_motion(evidence, match, votes, seeds);
  const std::optional<Pose> host = evidence.host_motion(match);
  const bool estimated = evidence.frame().pose_provenance >= PoseProvenance::Estimated;
  if (host && (estimated || source == MotionSource::Host)) {
    votes.note("motion: the host's");
    RigidMotion motion;
    motion.ok = true;
    motion.T_current_reference = *host;
    return motion;
  }
  if (source == MotionSource::Auto) return detail::fitted_motion(evidence, match, votes, seeds);
  votes.note("motion: no poses from the host");
  return std::nullopt;
}

}  // namespace dynfilter
