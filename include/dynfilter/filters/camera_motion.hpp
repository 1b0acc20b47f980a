// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/context/context.hpp>
#include <dynfilter/core/parameters.hpp>
#include <optional>
#include <string>
#include <vector>

namespace dynfilter {

/// Where a filter takes the camera's motion from.
enum class MotionSource {
  Seeds,  ///< fitted on the features that no earlier stage suspects
  Host,   ///< the host's poses
  Auto    ///< the host's where both are estimated, else fitted
};

template <class P>
Field<P> motion_source(const char* name, MotionSource P::*member) {
  return choice(name, member,
                {{"seeds", MotionSource::Seeds}, {"host", MotionSource::Host}, {"auto", MotionSource::Auto}},
                "the camera's motion: fitted on seeds, the host's, or the host's where it is estimated");
}

namespace detail {

/// On the seeds; on all features when too few of them carry a motion.
inline std::optional<RigidMotion> fitted_motion(Context& context, const Match& match,
                                                std::vector<int>& seeds) {
  for (const bool all : {false, true}) {
    context.collect_seeds(match, all, seeds);
    const RigidMotion& motion = context.rigid_motion(match, seeds);
    if (!motion.ok) {
      if (all) context.note(std::string("motion: none, ") + to_string(motion.note));
      continue;
    }
    context.note("motion: " + std::to_string(motion.inliers) + " of " + std::to_string(motion.points) +
                 (all ? " features (too few seeds)" : " seeds"));
    return motion;
  }
  return std::nullopt;
}

}  // namespace detail

/// The camera's motion since the match's reference, T_current_reference. Nullopt when there is none; the
/// report says why, and where it came from. The host's motion has no inliers and no covariance. `seeds`:
/// scratch.
inline std::optional<RigidMotion> camera_motion(Context& context, const Match& match, MotionSource source,
                                                std::vector<int>& seeds) {
  if (source == MotionSource::Seeds) return detail::fitted_motion(context, match, seeds);
  const std::optional<Pose> host = context.host_motion(match);
  const bool estimated = context.frame().pose_provenance >= PoseProvenance::Estimated;
  if (host && (estimated || source == MotionSource::Host)) {
    context.note("motion: the host's");
    RigidMotion motion;
    motion.ok = true;
    motion.T_current_reference = *host;
    return motion;
  }
  if (source == MotionSource::Auto) return detail::fitted_motion(context, match, seeds);
  context.note("motion: the host has none");
  return std::nullopt;
}

}  // namespace dynfilter
