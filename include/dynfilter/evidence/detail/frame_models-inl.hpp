// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/evidence/frame_models.hpp>

#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/inline.hpp>
#include <dynfilter/evidence/reused_slots.hpp>
#include <dynfilter/geometry/stereo_depth.hpp>

namespace dynfilter {

DYNFILTER_INLINE void FrameModels::begin() {
  detail::free_slots(two_views_);
  detail::free_slots(rigid_motions_);
}

DYNFILTER_INLINE const TwoViewModel& FrameModels::two_view(const Match& match,
                                                           const std::vector<int>& seeds) {
  return fitted(two_views_, match, seeds, [&] {
    const FrameView& frame = current_.frame();
    return two_view_.estimate(match.reference_undistorted_px, current_.undistorted_pixels(), seeds,
                              frame.camera ? &*frame.camera : nullptr);
  });
}

DYNFILTER_INLINE const RigidMotion& FrameModels::rigid_motion(const Match& match,
                                                              const std::vector<int>& seeds,
                                                              const std::optional<Pose>& prior) {
  return fitted(rigid_motions_, match, seeds, [&] {
    rigid_motion_.options().depth_noise = depth_noise_of(current_.frame());
    return rigid_motion_.estimate(current_.frame().camera.value_or(Camera()), match.reference_points_m,
                                  current_.points_m(), seeds, prior);
  });
}

template <class Model, class Fit>
const Model& FrameModels::fitted(std::list<Fitted<Model>>& known, const Match& match,
                                 const std::vector<int>& seeds, const Fit& fit) {
  for (const Fitted<Model>& slot : known)
    if (slot.valid && slot.match == &match && slot.seeds == seeds) return slot.model;
  Fitted<Model>& slot = detail::next_slot(known);
  slot.match = &match;
  slot.seeds = seeds;
  slot.model = fit();
  return slot.model;
}

}  // namespace dynfilter
