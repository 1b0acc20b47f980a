// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/config/parameters.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/correspondence/match.hpp>
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

/// The camera's motion since the match's reference, T_current_reference.
/// nullopt if there is none; the report names the reason or the source.
/// The host's motion has no inliers and no covariance. `seeds` is a buffer.
std::optional<RigidMotion> camera_motion(const Evidence& evidence, const Match& match, MotionSource source,
                                         Votes& votes, std::vector<int>& seeds);

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/evidence/detail/camera_motion-inl.hpp>
#endif
