// SPDX-License-Identifier: MIT
#include <dynfilter/geometry/two_view.hpp>
#include <limits>
#include <opencv2/calib3d.hpp>

#include "doctest/doctest.h"
#include "geometry/two_view_scene.hpp"

namespace two_view_test {

using namespace dynfilter;
using namespace geometry_test;

namespace {

const Eigen::Vector3d kAxis(0.3, 1, 0.2);

struct Score {
  double flagged_static = 0, found_movers = 0, unsaid_movers = 0;
};

/// Threshold: three standard deviations of the distance to a line in the current image, at least 1 px.
/// Only movers that the true model can detect count: those off their epipolar line in `truth`.
Score score(const TwoViewModel& model, const TwoViewScene& scene, double noise_px, const Matrix9* truth) {
  const double threshold = std::max(1.0, 3 * std::sqrt(2.0) * noise_px);
  Score out;
  int visible = 0;
  for (int i = 0; i < scene.static_count + scene.mover_count; ++i) {
    const auto verdict = judge(model, scene.reference[i], scene.current[i], threshold);
    if (i < scene.static_count) {
      out.flagged_static += verdict == TwoViewVerdict::Inconsistent;
    } else if (!truth || epipolar_distance_px(*truth, scene.reference[i], scene.current[i]) > threshold) {
      ++visible;
      out.found_movers += verdict == TwoViewVerdict::Inconsistent;
      out.unsaid_movers += verdict == TwoViewVerdict::CannotSay;
    }
  }
  out.flagged_static /= scene.static_count;
  out.found_movers = visible > 0 ? out.found_movers / visible : 1;
  out.unsaid_movers = visible > 0 ? out.unsaid_movers / visible : 0;
  return out;
}

/// All kinds of movers, both directions, three seeds.
/// Few static features are flagged, and movers are found.
template <class CheckKind>
void check_scene(Relief relief, const Pose& T, double noise_px, bool calibrated, CheckKind check_kind) {
  const Camera cam = camera();
  const Matrix9 truth = geometry_test::fundamental_from_pose(cam, T);
  TwoViewEstimator estimator;
  for (Movers movers :
       {Movers::None, Movers::Together, Movers::Anyhow, Movers::TwoGroups, Movers::Expanding}) {
    for (double direction : {60.0, 150.0}) {
      for (int seed = 1; seed <= 3; ++seed) {
        TwoViewRecipe recipe;
        recipe.relief = relief, recipe.motion = T, recipe.noise_px = noise_px, recipe.movers = movers;
        recipe.direction_deg = direction, recipe.seed = seed;
        const TwoViewScene scene(recipe);
        const TwoViewModel model =
            estimator.estimate(scene.reference, scene.current, scene.all(), calibrated ? &cam : nullptr);
        const bool lines = model.kind == TwoViewKind::Fundamental;
        const Score s = score(model, scene, noise_px, lines ? &truth : nullptr);
        CAPTURE(noise_px);
        CAPTURE(calibrated);
        CAPTURE(static_cast<int>(movers));
        CAPTURE(direction);
        CAPTURE(seed);
        CAPTURE(to_string(model.reason));
        CAPTURE(s.unsaid_movers);
        CHECK(s.flagged_static <= 0.02);
        CHECK(s.found_movers >= 0.9);
        check_kind(model);
      }
    }
  }
}

template <class CheckKind>
void check_scene(Relief relief, const Pose& T, CheckKind check_kind) {
  for (double noise : {0.0, 0.3, 0.5}) {
    for (bool calibrated : {true, false}) check_scene(relief, T, noise, calibrated, check_kind);
  }
}

}  // namespace

TEST_CASE("two views: a general scene is Fundamental") {
  const auto general = [](const TwoViewModel& m) {
    CHECK(m.kind == TwoViewKind::Fundamental);
    CHECK(m.reason == TwoViewReason::General);
    CHECK_FALSE(m.ambiguous);
  };
  check_scene(Relief::General, motion(2, kAxis, {0.08, 0.02, 0.05}), general);
  check_scene(Relief::General, motion(1, kAxis, {0, 0, 0.15}), general);
}

TEST_CASE("two views: a plane is not Fundamental, and movers on it are found") {
  const auto plane = [](const TwoViewModel& m) {
    CHECK(m.kind == TwoViewKind::Homography);
    CHECK_FALSE(m.ambiguous);
  };
  check_scene(Relief::Plane, motion(2, kAxis, {0.1, 0.02, 0.05}), plane);
  check_scene(Relief::Plane, motion(1, kAxis, {0.02, 0, 0.12}), plane);
  check_scene(Relief::FrontalPlane, motion(1, kAxis, {0.1, 0.02, 0}), plane);
}

TEST_CASE("two views: pure rotation and no motion have no baseline") {
  for (double noise : {0.0, 0.3, 0.5}) {
    check_scene(Relief::General, motion(2, kAxis, {0, 0, 0}), noise, true, [](const TwoViewModel& m) {
      CHECK(m.kind == TwoViewKind::Rotation);
      CHECK(m.reason == TwoViewReason::PureRotation);
    });
    check_scene(Relief::General, motion(0, kAxis, {0, 0, 0}), noise, true, [](const TwoViewModel& m) {
      CHECK(m.kind == TwoViewKind::Rotation);
      CHECK(m.reason == TwoViewReason::NoMotion);
    });
    const auto homography = [](const TwoViewModel& m) { CHECK(m.kind == TwoViewKind::Homography); };
    check_scene(Relief::General, motion(2, kAxis, {0, 0, 0}), noise, false, homography);
    check_scene(Relief::General, motion(0, kAxis, {0, 0, 0}), noise, false, homography);
  }
}

TEST_CASE("two views: a baseline of 3 mm keeps its movers") {
  const auto any = [](const TwoViewModel& m) { CHECK(m.kind != TwoViewKind::None); };
  check_scene(Relief::General, motion(1, kAxis, {0.003, 0, 0}), any);
  check_scene(Relief::General, motion(1, kAxis, {0, 0, 0.003}), any);
  check_scene(Relief::Room, motion(1, kAxis, {0.003, 0, 0}), any);
}

TEST_CASE("two views: baselines between none and plenty") {
  const auto any = [](const TwoViewModel& m) { CHECK(m.kind != TwoViewKind::None); };
  for (double noise : {0.0, 0.3}) {
    for (double t : {0.005, 0.01, 0.02, 0.03, 0.06}) {
      CAPTURE(t);
      check_scene(Relief::General, motion(1, kAxis, {t, 0, 0}), noise, true, any);
    }
  }
}

TEST_CASE("two views: static points off a plane are not flagged in bulk") {
  const Pose T = motion(1, kAxis, {0.1, 0.02, 0});
  for (double noise : {0.0, 0.3, 0.5}) {
    check_scene(Relief::PlaneAndBox, T, noise, true, [](const TwoViewModel& m) {
      CHECK(m.kind == TwoViewKind::Fundamental);
      CHECK(m.reason == TwoViewReason::CalibratedParallax);
    });
    // Without a camera they cannot be separated from movers.
    // Neither is flagged, and the model is ambiguous.
    TwoViewRecipe recipe;
    recipe.relief = Relief::PlaneAndBox, recipe.motion = T, recipe.noise_px = noise;
    const TwoViewScene scene(recipe);
    TwoViewEstimator estimator;
    const TwoViewModel model = estimator.estimate(scene.reference, scene.current, scene.all());
    CHECK(model.ambiguous);
    CHECK(score(model, scene, noise, nullptr).flagged_static < 0.02);
  }
}

TEST_CASE("two views: movers may be the majority outside the seeds") {
  TwoViewRecipe recipe;
  recipe.motion = motion(2, kAxis, {0.08, 0.02, 0.05}), recipe.noise_px = 0.3;
  recipe.movers = Movers::Together, recipe.mover_count = 900, recipe.static_count = 300;
  const TwoViewScene scene(recipe);
  std::vector<int> seeds = scene.all();
  seeds.resize(300);
  const Camera cam = camera();
  TwoViewEstimator estimator;
  const TwoViewModel model = estimator.estimate(scene.reference, scene.current, seeds, &cam);
  const Matrix9 truth = geometry_test::fundamental_from_pose(cam, recipe.motion);
  const Score s = score(model, scene, 0.3, &truth);
  CHECK(model.seeds == 300);
  CHECK(s.flagged_static < 0.02);
  CHECK(s.found_movers > 0.95);
}

TEST_CASE("two views: exact matches give the analytic F, and the exact rotation") {
  TwoViewRecipe recipe;
  recipe.motion = motion(2, kAxis, {0.08, 0.02, 0.05});
  const TwoViewScene scene(recipe);
  const Camera cam = camera();
  TwoViewEstimator estimator;
  const TwoViewModel model = estimator.estimate(scene.reference, scene.current, scene.all());
  const Matrix9 truth = geometry_test::fundamental_from_pose(cam, recipe.motion);
  const TwoViewScene fresh([&] {
    recipe.seed = 99;
    return recipe;
  }());
  double worst = 0;
  for (int i = 0; i < 1000; ++i) {
    worst = std::max(worst, epipolar_distance_px(model.F, fresh.reference[i], fresh.current[i]));
  }
  CHECK(worst < 0.01);
  CHECK(model.sigma_px < 0.01);
  recipe.motion = motion(2, kAxis, {0, 0, 0});
  const TwoViewScene turn(recipe);
  const TwoViewModel rotation = estimator.estimate(turn.reference, turn.current, turn.all(), &cam);
  const Eigen::Matrix3d K = detail::camera_matrix(cam);
  Eigen::Matrix3d H = K * recipe.motion.R() * K.inverse();
  H /= H(2, 2);
  CHECK((detail::rows(rotation.H) - H).cwiseAbs().maxCoeff() < 0.01);
  CHECK(truth != Matrix9{});
}

TEST_CASE("two views: the noise is estimated") {
  for (double noise : {0.2, 0.3, 0.5}) {
    TwoViewRecipe recipe;
    recipe.noise_px = noise, recipe.movers = Movers::Together;
    for (const Pose& T : {motion(2, kAxis, {0.08, 0.02, 0.05}), motion(2, kAxis, {0, 0, 0})}) {
      recipe.motion = T;
      const TwoViewScene scene(recipe);
      const Camera cam = camera();
      TwoViewEstimator estimator;
      const TwoViewModel model = estimator.estimate(scene.reference, scene.current, scene.all(), &cam);
      CHECK(model.sigma_px == doctest::Approx(noise).epsilon(0.12));
    }
  }
}

TEST_CASE("two views: recalls at least what OpenCV's USAC_FAST recalls") {
  for (int outliers : {430, 1000}) {  // 30 and 50 %
    int mine = 0, anchor = 0, all = 0;
    for (int seed = 1; seed <= 100; ++seed) {
      TwoViewRecipe recipe;
      recipe.motion = motion(2, kAxis, {0.08, 0.02, 0.05});
      recipe.noise_px = 0.3, recipe.mismatch_count = outliers, recipe.seed = seed;
      const TwoViewScene scene(recipe);
      TwoViewEstimator estimator;
      const TwoViewModel model = estimator.estimate(scene.reference, scene.current, scene.all());
      const cv::Mat F = cv::findFundamentalMat(scene.reference, scene.current, cv::USAC_FAST, 1.0, 0.99);
      REQUIRE(F.rows == 3);
      Matrix9 theirs;
      std::copy(F.ptr<double>(), F.ptr<double>() + 9, theirs.begin());
      for (int i = 0; i < scene.static_count; ++i, ++all) {
        mine += sampson_distance_px(model.F, scene.reference[i], scene.current[i]) < 1;
        anchor += sampson_distance_px(theirs, scene.reference[i], scene.current[i]) < 1;
      }
    }
    CHECK(mine >= anchor);
    CHECK(mine > 0.995 * all);
  }
}

TEST_CASE("two views: the same twice, after other work, and with indices that do not exist") {
  TwoViewRecipe recipe;
  recipe.motion = motion(2, kAxis, {0.08, 0.02, 0.05});
  recipe.noise_px = 0.3, recipe.movers = Movers::Together, recipe.mismatch_count = 300;
  const TwoViewScene scene(recipe);
  recipe.seed = 5, recipe.static_count = 2000;
  const TwoViewScene other(recipe);
  TwoViewEstimator a, b;
  const TwoViewModel x = a.estimate(scene.reference, scene.current, scene.all());
  b.estimate(other.reference, other.current, other.all());
  std::vector<int> seeds = scene.all();
  seeds.push_back(-1), seeds.push_back(1 << 30);
  const TwoViewModel y = b.estimate(scene.reference, scene.current, seeds);
  CHECK(x.F == y.F);
  CHECK(x.inliers == y.inliers);
}

TEST_CASE("two views: degenerate and odd input is None and never throws") {
  TwoViewEstimator estimator;
  const TwoViewScene scene(TwoViewRecipe{});
  const Camera cam = camera();
  for (int n = 0; n <= 19; ++n) {
    std::vector<int> few = scene.all();
    few.resize(n);
    CHECK(estimator.estimate(scene.reference, scene.current, few, &cam).kind == TwoViewKind::None);
  }
  estimator.options().min_seeds = 0;
  for (int n = 0; n <= 7; ++n) {
    std::vector<int> few = scene.all();
    few.resize(n);
    CHECK(estimator.estimate(scene.reference, scene.current, few).kind == TwoViewKind::None);
  }
  const std::vector<cv::Point2f> same(100, {320, 240});
  std::vector<int> all = scene.all();
  all.resize(100);
  CHECK(estimator.estimate(same, same, all, &cam).kind == TwoViewKind::None);
  std::vector<cv::Point2f> line;
  for (int i = 0; i < 100; ++i) line.emplace_back(5.0F * static_cast<float>(i), 3.0F * static_cast<float>(i));
  const TwoViewModel on_line = estimator.estimate(line, line, all, &cam);
  CHECK(on_line.kind == TwoViewKind::None);
  CHECK(on_line.reason == TwoViewReason::CollinearSeeds);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  CHECK(estimator.estimate(std::vector<cv::Point2f>(100, {nan, nan}), same, all).kind == TwoViewKind::None);
  TwoViewRecipe chaos;
  chaos.static_count = 0, chaos.mismatch_count = 500;
  const TwoViewScene noise(chaos);
  const TwoViewModel none = estimator.estimate(noise.reference, noise.current, noise.all(), &cam);
  CHECK(none.kind == TwoViewKind::None);
  CHECK(judge(none, {1, 1}, {2, 2}, 1) == TwoViewVerdict::CannotSay);
}

TEST_CASE("two views: single missing points are ignored") {
  TwoViewRecipe recipe;
  recipe.motion = motion(2, kAxis, {0.08, 0.02, 0.05});
  TwoViewScene scene(recipe);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (int i = 0; i < 100; ++i) scene.current[i] = {nan, 5};
  TwoViewEstimator estimator;
  const TwoViewModel model = estimator.estimate(scene.reference, scene.current, scene.all());
  CHECK(model.seeds == 900);
  CHECK(model.inliers == 900);
  CHECK(judge(model, scene.reference[0], scene.current[0], 1) == TwoViewVerdict::CannotSay);
  CHECK(judge(model, scene.reference[200], scene.current[200], 1) == TwoViewVerdict::Consistent);
}

}  // namespace two_view_test
