// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/correspondence/match.hpp>
#include <dynfilter/evidence/current_frame.hpp>
#include <dynfilter/evidence/feature_tracks.hpp>
#include <dynfilter/geometry/depth_noise.hpp>
#include <dynfilter/geometry/rigid_motion.hpp>
#include <dynfilter/geometry/two_view.hpp>
#include <dynfilter/geometry/two_view_model.hpp>
#include <list>
#include <optional>
#include <vector>

namespace dynfilter {

/// Models fitted to the matches of one frame, each once for the same match and seeds.
class FrameModels {
 public:
  /// Refers to `current`, which must outlive it.
  explicit FrameModels(CurrentFrame& current) : current_(current) {}

  void begin();

  /// See Evidence::two_view().
  const TwoViewModel& two_view(const Match& match, const std::vector<int>& seeds);
  /// `prior`: a T_current_reference that competes as a hypothesis.
  const RigidMotion& rigid_motion(const Match& match, const std::vector<int>& seeds,
                                  const std::optional<Pose>& prior);

 private:
  template <class Model>
  struct Fitted {
    bool valid = false;
    const Match* match = nullptr;
    std::vector<int> seeds;
    Model model;
  };
  template <class Model, class Fit>
  static const Model& fitted(std::list<Fitted<Model>>& known, const Match& match,
                             const std::vector<int>& seeds, const Fit& fit);

  CurrentFrame& current_;
  TwoViewEstimator two_view_;
  RigidMotionEstimator rigid_motion_;
  std::list<Fitted<TwoViewModel>> two_views_;
  std::list<Fitted<RigidMotion>> rigid_motions_;
};

inline void FrameModels::begin() {
  detail::free_slots(two_views_);
  detail::free_slots(rigid_motions_);
}

inline const TwoViewModel& FrameModels::two_view(const Match& match, const std::vector<int>& seeds) {
  return fitted(two_views_, match, seeds, [&] {
    const FrameView& frame = current_.frame();
    return two_view_.estimate(match.reference_undistorted_px, current_.undistorted_pixels(), seeds,
                              frame.camera ? &*frame.camera : nullptr);
  });
}

inline const RigidMotion& FrameModels::rigid_motion(const Match& match, const std::vector<int>& seeds,
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
