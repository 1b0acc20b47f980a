// SPDX-License-Identifier: MIT
#include <Eigen/Core>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/evidence/frame_evidence.hpp>
#include <dynfilter/filters/background_motion.hpp>
#include <dynfilter/filters/flow_consistency.hpp>
#include <dynfilter/testing/exact_scene.hpp>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "doctest/doctest.h"

namespace motion_prior_test {

using namespace dynfilter;
using testing::ExactFrame;
using testing::ExactScene;
using testing::MovingBox;

namespace {

using Prior = std::function<std::optional<MotionPrior>(const Pose& T_current_reference)>;

MotionPrior gyroscope(const Pose& T) {
  return MotionPrior::turn(T.R(), 1e-8 * Eigen::Matrix3d::Identity());
}

struct Played {
  std::vector<std::vector<Vote>> votes;  ///< per frame
  std::vector<bool> ignored;             ///< the filter says that it ignores the prior
  std::vector<double> kept, found;       ///< share of the static and of the moving features
};

template <class Filter>
Played play(const ExactScene& scene, int frames, const Prior& prior) {
  Filter filter;
  FrameEvidence evidence;
  evidence.set_history(filter.needs().history_frames);
  Votes votes;
  Played played;
  Pose last;
  for (int k = 0; k < frames; ++k) {
    const ExactFrame frame = scene.frame(k);
    FrameView view = frame.view();
    if (k > 0) view.motion_prior = prior(inverse(frame.T_world_camera) * last);
    last = frame.T_world_camera;
    evidence.begin(view, CallPoint::BeforePose);
    votes.reset(evidence.size());
    filter.apply(evidence, votes);
    evidence.end(false);
    std::vector<Vote> all;
    double sums[2] = {}, dynamic[2] = {};
    for (std::size_t i = 0; i < frame.size(); ++i) {
      all.push_back(votes[i]);
      const int mover = frame.label[i] > 0 ? 1 : 0;
      sums[mover] += 1, dynamic[mover] += votes[i] == Vote::Dynamic ? 1 : 0;
    }
    played.votes.push_back(all);
    played.ignored.push_back(votes.notes().find("contradicts the images") != std::string::npos);
    played.kept.push_back(1 - dynamic[0] / std::max(1.0, sums[0]));
    played.found.push_back(dynamic[1] / std::max(1.0, sums[1]));
  }
  return played;
}

ExactScene walker_scene() {
  return ExactScene()
      .points(300)
      .mover(MovingBox(60).moving({0.04, 0, 0}))
      .pixel_noise(0.1)
      .depth_noise(0.0014);
}

}  // namespace

TEST_CASE_TEMPLATE("motion prior: a lie is noticed within half a second, said, and does no harm", Filter,
                   BackgroundMotionFilter, FlowConsistencyFilter) {
  const bool mono = std::is_same_v<Filter, FlowConsistencyFilter>;
  ExactScene scene = walker_scene();
  if (mono) scene.mono();
  constexpr int kFrames = 45;
  const Played alone = play<Filter>(scene, kFrames, [](const Pose&) { return std::nullopt; });
  const auto lying = [&](const Eigen::Vector3d& lie_rad) {
    return play<Filter>(scene, kFrames, [=](const Pose& T) {
      return gyroscope(Pose::from(exp_so3(lie_rad) * T.R(), T.t()));
    });
  };
  for (const Eigen::Vector3d& lie_rad : {Eigen::Vector3d(0.02, 0, 0), Eigen::Vector3d(0, -0.01, 0.01)}) {
    const Played lied = lying(lie_rad);
    for (std::size_t k = 15; k < kFrames; ++k) {
      CAPTURE(k);
      CHECK(lied.ignored[k]);
      CHECK(lied.kept[k] >= alone.kept[k] - 0.02);
      CHECK(lied.found[k] >= alone.found[k] - 0.02);
    }
  }
}

TEST_CASE_TEMPLATE("motion prior: the truth changes little where vision suffices", Filter,
                   BackgroundMotionFilter, FlowConsistencyFilter) {
  ExactScene scene = walker_scene();
  if (std::is_same_v<Filter, FlowConsistencyFilter>) scene.mono();
  const Played alone = play<Filter>(scene, 30, [](const Pose&) { return std::nullopt; });
  const Played with = play<Filter>(scene, 30, gyroscope);
  for (std::size_t k = 5; k < 30; ++k) {
    CAPTURE(k);
    CHECK_FALSE(with.ignored[k]);
    CHECK(with.kept[k] >= alone.kept[k] - 0.01);
    CHECK(with.found[k] >= alone.found[k] - 0.02);
  }
}

TEST_CASE("motion prior: of another frame, or unusable, it is as if there were none") {
  const ExactScene scene = walker_scene();
  const Played alone = play<BackgroundMotionFilter>(scene, 10, [](const Pose&) { return std::nullopt; });
  const std::vector<std::function<void(MotionPrior&)>> spoil{
      [](MotionPrior& prior) { prior.reference_frame_id = 1000; },
      [](MotionPrior& prior) { prior.covariance[21] = 0; },
      [](MotionPrior& prior) { prior.covariance[35] = std::numeric_limits<double>::quiet_NaN(); },
      [](MotionPrior& prior) { prior.covariance[22] = std::numeric_limits<double>::quiet_NaN(); },
      [](MotionPrior& prior) { prior.covariance[28] = 1e300; },
      [](MotionPrior& prior) { prior.T_current_reference.rotation[0] = 2; }};
  for (std::size_t k = 0; k < spoil.size(); ++k) {
    CAPTURE(k);
    const Played spoiled = play<BackgroundMotionFilter>(scene, 10, [&](const Pose& T) {
      MotionPrior prior = gyroscope(T);
      spoil[k](prior);
      return prior;
    });
    CHECK(spoiled.votes == alone.votes);
  }
}

}  // namespace motion_prior_test
