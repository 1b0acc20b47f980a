// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/config/parameters.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/evidence/evidence.hpp>
#include <dynfilter/geometry/rigid_motion.hpp>
#include <optional>
#include <vector>

namespace dynfilter {

/// Source of the camera's motion.
enum class MotionSource {
  Seeds,  ///< fitted on features that no earlier stage suspects
  Host,   ///< from the host's poses
  Auto    ///< from the host's poses if both are estimated, else fitted
};

template <class P>
Field<P> motion_source(const char* name, MotionSource P::*member) {
  return choice(name, member,
                {{"seeds", MotionSource::Seeds}, {"host", MotionSource::Host}, {"auto", MotionSource::Auto}},
                "camera motion: seeds fits it on the seeds, host uses the host's poses, auto prefers "
                "estimated poses of the host");
}

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

/// The camera's motion since the match's reference, T_current_reference. nullopt if there is none; the report
/// names the reason or the source. The host's motion has no inliers and no covariance. `seeds` is a buffer.
inline std::optional<RigidMotion> camera_motion(const Evidence& evidence, const Match& match,
                                                MotionSource source, Votes& votes, std::vector<int>& seeds) {
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
