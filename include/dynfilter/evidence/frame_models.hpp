// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/pose.hpp>
#include <dynfilter/correspondence/match.hpp>
#include <dynfilter/evidence/current_frame.hpp>
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
  explicit FrameModels(CurrentFrame& current) : current_(current) {}

  void begin();

  const TwoViewModel& two_view(const Match& match, const std::vector<int>& seeds);
  /// `prior`: a motion that competes as a hypothesis.
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

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/evidence/detail/frame_models-inl.hpp>
#endif
