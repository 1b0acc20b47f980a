// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <dynfilter/core/error.hpp>
#include <dynfilter/core/needs.hpp>
#include <dynfilter/testing/exact_scene_presets.hpp>
#include <opencv2/calib3d.hpp>
#include <set>

#include "doctest/doctest.h"
#include "support/digest.hpp"

namespace exact_scene_test {

using namespace dynfilter;
using testing::CameraStep;
using testing::ExactFrame;
using testing::ExactScene;
using testing::MovingBox;
using testing::Truth;

namespace {

Eigen::Vector3d back_project(const ExactFrame& f, std::size_t i) {
  const cv::Point2f px = (f.keypoints_undistorted.empty() ? f.keypoints : f.keypoints_undistorted)[i].pt;
  return testing::ray(f.camera, px) * static_cast<double>(f.depth_m[i]);
}

bool same(const ExactFrame& a, const ExactFrame& b) {
  if (a.point != b.point || a.label != b.label || a.reference_index != b.reference_index ||
      a.truth != b.truth || a.depth_m.size() != b.depth_m.size())
    return false;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const bool same_depth =
        a.depth_m[i] == b.depth_m[i] || (std::isnan(a.depth_m[i]) && std::isnan(b.depth_m[i]));
    if (a.keypoints[i].pt != b.keypoints[i].pt || !same_depth) return false;
  }
  return true;
}

// Distance [px] of a feature from the epipolar line of its match, with true poses.
// -1 without a match.
double epipolar_distance(const ExactScene& scene, int k, const ExactFrame& now, const ExactFrame& before,
                         std::size_t i) {
  const std::int32_t j = now.reference_index[i];
  if (j < 0) return -1;
  const Pose T = inverse(scene.T_world_camera(k)) * scene.T_world_camera(k - 1);  // now <- before
  Eigen::Matrix3d cross;
  cross << 0, -T.t().z(), T.t().y(), T.t().z(), 0, -T.t().x(), -T.t().y(), T.t().x(), 0;
  const Camera& c = now.camera;
  Eigen::Matrix3d K = Eigen::Matrix3d::Identity();
  K(0, 0) = c.fx_px, K(1, 1) = c.fy_px, K(0, 2) = c.cx_px, K(1, 2) = c.cy_px;
  const cv::Point2f p = now.keypoints[i].pt, q = before.keypoints[static_cast<std::size_t>(j)].pt;
  const Eigen::Vector3d line =
      K.inverse().transpose() * cross * T.R() * K.inverse() * Eigen::Vector3d(q.x, q.y, 1);
  return std::abs(line.dot(Eigen::Vector3d(p.x, p.y, 1))) / std::hypot(line.x(), line.y());
}

double share(const std::vector<int>& labels, bool of_movers) {
  return static_cast<double>(
             std::count_if(labels.begin(), labels.end(), [&](int l) { return (l > 0) == of_movers; })) /
         static_cast<double>(labels.size());
}

}  // namespace

TEST_CASE("the digest of a scene: every compiler draws the random numbers in the same order") {
  const ExactScene scene =
      ExactScene().mover(MovingBox()).pixel_noise(0.5).depth_noise(0.002).mismatches(0.1);
  const ExactFrame frame = scene.frame(3);
  digest::Digest digest;
  for (std::size_t i = 0; i < frame.size(); ++i) {
    const auto thousandths = [](float value) {
      return static_cast<std::uint64_t>(std::lround(1000 * value));
    };
    digest.add(thousandths(frame.keypoints[i].pt.x));
    digest.add(thousandths(frame.keypoints[i].pt.y));
    digest.add(thousandths(frame.depth_m[i]));
    digest.add(static_cast<std::uint64_t>(frame.reference_index[i]));
  }
  CHECK(digest.text() == "95c3aefc29521d51");
}

TEST_CASE("A scene is the same every time, in any order of frames, and another for another seed") {
  const auto make = [](std::uint64_t seed) {
    return ExactScene()
        .seed(seed)
        .mover(MovingBox())
        .pixel_noise(0.5)
        .depth_noise(0.002)
        .mismatches(0.1)
        .missing_depth(0.1);
  };
  const ExactScene a = make(1), b = make(1), c = make(2);
  const ExactFrame last = a.frame(9);
  for (int k = 0; k < 9; ++k) b.frame(k);
  CHECK(same(last, b.frame(9)));
  CHECK_FALSE(same(last, c.frame(9)));
  CHECK_FALSE(same(last, a.frame(8)));
}

TEST_CASE("Static points stay where they are, and movers go where they are told") {
  for (const int gap : {1, 4}) {
    const Eigen::Vector3d step_m(0.05, -0.02, 0.03);
    const ExactScene scene = ExactScene().mover(MovingBox(60).at({0, 0, 2.5}).moving(step_m)).gap(gap);
    const ExactFrame now = scene.frame(6), before = scene.frame(6 - gap);
    REQUIRE(now.reference_frame_id == 6 - gap);
    int compared[2] = {0, 0};
    for (std::size_t i = 0; i < now.size(); ++i) {
      const std::int32_t j = now.reference_index[i];
      if (j < 0) continue;
      const Eigen::Vector3d p = now.T_world_camera.isometry() * back_project(now, i);
      const Eigen::Vector3d q =
          before.T_world_camera.isometry() * back_project(before, static_cast<std::size_t>(j));
      const Eigen::Vector3d moved_m =
          now.label[i] == 0 ? Eigen::Vector3d(0, 0, 0) : Eigen::Vector3d(step_m * gap);
      CHECK((p - q - moved_m).norm() < 1e-5);
      CHECK(now.truth[i] == (now.label[i] == 0 ? Truth::Static : Truth::Dynamic));
      CHECK(scene.is_dynamic(6, i) == (now.label[i] == 1));
      ++compared[now.label[i]];
    }
    CHECK(compared[0] > 150);
    CHECK(compared[1] > 50);
  }
}

TEST_CASE("A mover may turn, stand still first, or follow any motion") {
  const MovingBox turning = MovingBox(10).at({0, 0, 3}).turning({0, 0.1, 0}).still_until(4);
  CHECK((turning.T_world_object(4).translation() - Eigen::Vector3d(0, 0, 3)).norm() == 0);
  CHECK(turning.T_world_object(4).linear() == Eigen::Matrix3d::Identity());
  const Eigen::AngleAxisd turn(turning.T_world_object(9).linear());
  CHECK(turn.angle() == doctest::Approx(0.5));
  CHECK(turn.axis().y() == doctest::Approx(1));
  MovingBox jumping = MovingBox(1).following(
      [](int k) { return Pose::from(Eigen::Matrix3d::Identity(), Eigen::Vector3d(k == 2 ? 1 : 0, 0, 3)); });
  CHECK(jumping.T_world_object(1).translation().x() == 0);
  CHECK(jumping.T_world_object(2).translation().x() == 1);
}

TEST_CASE("Dynamic means more than 10 mm and more than 1 px over five frames") {
  const auto truths = [](const ExactScene& scene, int k) {
    std::set<Truth> seen;
    const ExactFrame frame = scene.frame(k);
    for (std::size_t i = 0; i < frame.size(); ++i)
      if (frame.label[i] == 1) seen.insert(frame.truth[i]);
    return seen;
  };
  const auto scene = [](const Eigen::Vector3d& step_m) {
    return ExactScene()
        .points(10)
        .camera_motion(CameraStep::None)
        .mover(MovingBox(40).at({0, 0, 2}).moving(step_m).still_until(3));
  };
  const std::set<Truth> is_static{Truth::Static}, dynamic{Truth::Dynamic}, dont_care{Truth::DontCare};
  CHECK(truths(scene({0.0024, 0, 0}), 3) == is_static);
  CHECK(truths(scene({0.0024, 0, 0}), 4) == dont_care);  // 2.4 mm
  CHECK(truths(scene({0.0024, 0, 0}), 7) == dont_care);  // 9.6 mm
  CHECK(truths(scene({0.0024, 0, 0}), 8) == dynamic);    // 12 mm, 3.2 px
  // 7.5 mm over five frames, regardless of earlier motion.
  CHECK(truths(scene({0.0015, 0, 0}), 30) == dont_care);
  CHECK(truths(scene({0.0015, 0, 0}).truth_over(10), 30) == dynamic);
  // Along the line of sight in the middle of the image: far in metres, less than a pixel.
  const ExactScene away =
      ExactScene()
          .points(0)
          .camera_motion(CameraStep::None)
          .mover(MovingBox(40).at({0, 0, 2}).half_size({0.002, 0.002, 0.002}).moving({0, 0, 0.03}));
  CHECK(truths(away, 6) == dont_care);
}

TEST_CASE("The order of features changes, not what they are") {
  const ExactScene plain = ExactScene().mover(MovingBox()).order(0).pixel_noise(0.3),
                   shuffled = ExactScene(plain).order(7);
  const ExactFrame a = plain.frame(3), b = shuffled.frame(3);
  CHECK(std::is_sorted(a.point.begin(), a.point.end()));
  CHECK_FALSE(std::is_sorted(b.point.begin(), b.point.end()));
  CHECK(b.point != ExactScene(plain).order(8).frame(3).point);
  REQUIRE(a.size() == b.size());
  const ExactFrame a2 = plain.frame(2), b2 = shuffled.frame(2);
  for (std::size_t i = 0; i < b.size(); ++i) {
    const auto at = std::lower_bound(a.point.begin(), a.point.end(), b.point[i]) - a.point.begin();
    const auto j = static_cast<std::size_t>(at);
    CHECK(a.keypoints[j].pt == b.keypoints[i].pt);
    CHECK(a.depth_m[j] == b.depth_m[i]);
    const std::int32_t ra = a.reference_index[j], rb = b.reference_index[i];
    REQUIRE((ra < 0) == (rb < 0));
    if (ra >= 0) CHECK(a2.point[static_cast<std::size_t>(ra)] == b2.point[static_cast<std::size_t>(rb)]);
  }
}

TEST_CASE("Points enter and leave, and none is outside the image") {
  const ExactScene scene =
      ExactScene().mover(MovingBox(60).at({0.8, 0, 2.5}).moving({0.05, 0, 0})).pixel_noise(2);
  std::set<int> first, last;
  for (int k = 0; k < 20; ++k) {
    const ExactFrame frame = scene.frame(k);
    for (std::size_t i = 0; i < frame.size(); ++i) {
      CHECK(testing::in_image(frame.camera, frame.keypoints[i].pt));
      CHECK(frame.depth_m[i] > 0.0F);
      if (k == 0) first.insert(frame.point[i]);
      if (k == 19) last.insert(frame.point[i]);
    }
    CHECK(frame.size() > 150);
  }
  std::vector<int> left, entered;
  std::set_difference(first.begin(), first.end(), last.begin(), last.end(), std::back_inserter(left));
  std::set_difference(last.begin(), last.end(), first.begin(), first.end(), std::back_inserter(entered));
  CHECK(left.size() > 20);
  CHECK(entered.size() > 20);
}

TEST_CASE("What is behind a mover is not seen") {
  // Its front is at z = 2: a rectangle of +-0.5 m by +-0.4 m in front of a static camera.
  const ExactScene scene = ExactScene()
                               .points(2000)
                               .camera_motion(CameraStep::None)
                               .mover(MovingBox(100).at({0, 0, 2.2}).half_size({0.5, 0.4, 0.2}));
  const ExactFrame frame = scene.frame(0);
  int before_it = 0, on_it = 0;
  for (std::size_t i = 0; i < frame.size(); ++i) {
    const Eigen::Vector3d p = back_project(frame, i);
    const bool in_front_face = std::abs(p.x() / p.z()) < 0.5 / 2 && std::abs(p.y() / p.z()) < 0.4 / 2;
    if (frame.label[i] == 1) ++on_it;
    if (frame.label[i] != 0 || !in_front_face) continue;
    CHECK(p.z() <= 2.0);
    ++before_it;
  }
  CHECK(before_it > 20);
  CHECK(on_it == 100);
  CHECK(ExactScene().points(2000).camera_motion(CameraStep::None).frame(0).size() == 2000);
}

TEST_CASE("Noise, gaps and mismatches are as large as asked for") {
  const ExactScene clean = ExactScene().points(4000).order(0).horizon(1);
  const ExactScene noisy = ExactScene(clean)
                               .pixel_noise(0.7)
                               .depth_noise(0.002)
                               .missing_depth(0.2)
                               .missing_matches(0.3)
                               .mismatches(0.25);
  const ExactFrame a = clean.frame(1), b = noisy.frame(1);
  double n = 0, px2 = 0, depths = 0, z2 = 0;
  for (std::size_t i = 0, j = 0; i < a.size() && j < b.size();) {
    if (a.point[i] != b.point[j]) {
      a.point[i] < b.point[j] ? ++i : ++j;
      continue;
    }
    const cv::Point2f d = a.keypoints[i].pt - b.keypoints[j].pt;
    n += 1, px2 += static_cast<double>(d.dot(d));
    if (!std::isnan(b.depth_m[j])) {
      const double z = static_cast<double>(a.depth_m[i]),
                   dz = (static_cast<double>(b.depth_m[j]) - z) / (0.002 * z * z);
      depths += 1, z2 += dz * dz;
    }
    ++i, ++j;
  }
  // Standard errors of these estimates are 1 % to 3 %.
  CHECK(std::sqrt(px2 / 2 / n) == doctest::Approx(0.7).epsilon(0.05));
  CHECK(std::sqrt(z2 / depths) == doctest::Approx(1).epsilon(0.05));
  CHECK(depths / n == doctest::Approx(0.8).epsilon(0.05));
  const ExactFrame before = noisy.frame(0);
  double possible = 0, matched = 0, wrong = 0;
  for (std::size_t i = 0; i < b.size(); ++i) {
    possible += std::count(before.point.begin(), before.point.end(), b.point[i]) != 0 ? 1 : 0;
    if (b.reference_index[i] < 0) continue;
    matched += 1;
    const bool same_point = before.point[static_cast<std::size_t>(b.reference_index[i])] == b.point[i];
    CHECK(same_point == (b.mismatched[i] == 0));
    wrong += same_point ? 0 : 1;
  }
  CHECK(matched / possible == doctest::Approx(0.7).epsilon(0.06));
  CHECK(wrong / matched == doctest::Approx(0.25).epsilon(0.1));
}

TEST_CASE("Distorted keypoints are what OpenCV undistorts") {
  Camera camera = freiburg3_camera();
  camera.distortion = {0.2624, -0.9531, -0.0054, 0.0026, 1.1633};
  const ExactFrame frame = ExactScene().camera(camera).pixel_noise(0.5).frame(2);
  REQUIRE(frame.keypoints_undistorted.size() == frame.size());
  const cv::Matx33d K(camera.fx_px, 0, camera.cx_px, 0, camera.fy_px, camera.cy_px, 0, 0, 1);
  std::vector<cv::Point2f> px, undistorted;
  for (const cv::KeyPoint& k : frame.keypoints) px.push_back(k.pt);
  cv::undistortPoints(px, undistorted, K, camera.distortion, cv::noArray(), K,
                      cv::TermCriteria(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 100, 1e-9));
  double moved_px = 0;
  for (std::size_t i = 0; i < frame.size(); ++i) {
    CHECK(cv::norm(undistorted[i] - frame.keypoints_undistorted[i].pt) < 0.02);
    moved_px = std::max(moved_px, cv::norm(px[i] - undistorted[i]));
  }
  CHECK(moved_px > 2);
}

TEST_CASE("Boxes hold the movers' features, and may come late") {
  const ExactScene scene = ExactScene()
                               .mover(MovingBox(50).at({-0.5, 0, 2.5}).moving({0.05, 0, 0}))
                               .mover(MovingBox(20).at({0, 0, -3}).named("cat"))
                               .with_detections();
  const ExactFrame frame = scene.frame(4);
  REQUIRE(frame.detections);
  REQUIRE(frame.detections->size() == 1);  // the cat is behind the camera
  const Detection& box = frame.detections->front();
  CHECK(box.class_name == "person");
  CHECK(frame.detections_frame_id == 4);
  for (std::size_t i = 0; i < frame.size(); ++i)
    if (frame.label[i] == 1) CHECK(box.box.contains(frame.keypoints[i].pt));
  CHECK(box.box.area() < 640.0F * 480.0F / 4.0F);
  const ExactScene late = ExactScene(scene).with_detections(3);
  CHECK_FALSE(late.frame(2).detections.has_value());
  CHECK(late.frame(7).detections_frame_id == 4);
  CHECK(late.frame(7).detections->front().box == box.box);
  CHECK(late.frame(7).view().detections->frame_id == 4);
}

TEST_CASE("Descriptors of a point are alike, those of two points are not") {
  const ExactScene scene = ExactScene().points(100).with_descriptors(12);
  const ExactFrame now = scene.frame(1), before = scene.frame(0);
  REQUIRE(now.descriptors.rows == static_cast<int>(now.size()));
  for (std::size_t i = 0; i < now.size(); ++i)
    for (std::size_t j = 0; j < before.size(); ++j) {
      const double bits = cv::norm(now.descriptors.row(static_cast<int>(i)),
                                   before.descriptors.row(static_cast<int>(j)), cv::NORM_HAMMING);
      CHECK((bits <= 24) == (now.point[i] == before.point[j]));
    }
}

TEST_CASE("The view holds what was asked for and nothing else") {
  const auto inputs = [](const ExactScene& scene) {
    const ExactFrame frame = scene.frame(2);
    return inputs_of(frame.view());
  };
  const Input base = Input::Camera | Input::Correspondence;
  CHECK(inputs(ExactScene()) == (base | Input::Depth));
  CHECK(inputs(ExactScene().mono()) == base);
  CHECK(inputs(ExactScene().mono().without_matches()) == Input::Camera);
  CHECK(inputs(ExactScene().mono().with_poses().with_detections().with_descriptors().with_map_points()) ==
        (base | Input::Pose | Input::Detections | Input::Descriptors | Input::MapPoints));
  const ExactFrame first = ExactScene().gap(3).frame(2);
  CHECK_FALSE(first.view().matches.has_value());
  CHECK(ExactScene().points(0).frame(3).size() == 0);
  CHECK(ExactScene().points(0).frame(3).view().matches.has_value());
  CHECK_THROWS_AS(ExactScene().camera(Camera()), ConfigError);
}

TEST_CASE("Each preset is the trap it is named after") {
  for (const testing::Preset preset : testing::all_presets()) {
    CAPTURE(testing::to_string(preset));
    const ExactScene scene = testing::preset(preset).seed(3);
    const int k = 20;
    const ExactFrame now = scene.frame(k), before = scene.frame(k - 1);
    CHECK(now.size() > 200);
    double static_max = 0, mover_max = 0, moved_px = 0;
    for (std::size_t i = 0; i < now.size(); ++i) {
      if (now.reference_index[i] < 0) continue;
      moved_px =
          std::max(moved_px, cv::norm(now.keypoints[i].pt -
                                      before.keypoints[static_cast<std::size_t>(now.reference_index[i])].pt));
      const double d = epipolar_distance(scene, k, now, before, i);
      (now.label[i] == 0 ? static_max : mover_max) = std::max(now.label[i] == 0 ? static_max : mover_max, d);
    }
    CHECK(moved_px > 3);
    const bool baseline = preset != testing::Preset::PureRotation && preset != testing::Preset::NoMotion;
    if (baseline) CHECK(static_max < 0.05);
    if (preset == testing::Preset::AlongEpipolar) CHECK(mover_max < 0.05);
    if (preset == testing::Preset::General || preset == testing::Preset::Majority) CHECK(mover_max > 2);
    const double movers = share(now.label, true);
    if (preset == testing::Preset::Rigid)
      CHECK(movers == 0);
    else
      CHECK(movers > 0.1);
    const bool majority = preset == testing::Preset::Majority || preset == testing::Preset::DelayedMajority;
    CHECK((movers > 0.6) == majority);
  }
  const ExactFrame still = testing::preset(testing::Preset::DelayedMajority).frame(15);
  CHECK(std::count(still.truth.begin(), still.truth.end(), Truth::Static) == static_cast<int>(still.size()));
  const ExactFrame off = testing::preset(testing::Preset::DelayedMajority).frame(16);
  CHECK(std::count(off.truth.begin(), off.truth.end(), Truth::Dynamic) > static_cast<int>(off.size()) / 2);
}

TEST_CASE("A planar scene is a plane, and pure rotation has no baseline") {
  const ExactScene planar = testing::preset(testing::Preset::Planar);
  const ExactFrame frame = planar.frame(5);
  const Eigen::Vector3d normal(std::sin(0.35), 0, std::cos(0.35));
  for (std::size_t i = 0; i < frame.size(); ++i)
    if (frame.label[i] == 0)
      CHECK(normal.dot(frame.T_world_camera.isometry() * back_project(frame, i)) ==
            doctest::Approx(3 * std::cos(0.35)).epsilon(1e-5));
  CHECK(testing::preset(testing::Preset::PureRotation).T_world_camera(20).t().norm() == 0);
  CHECK(testing::preset(testing::Preset::SmallBaseline).T_world_camera(1).t().norm() ==
        doctest::Approx(0.003).epsilon(0.02));
}

}  // namespace exact_scene_test
