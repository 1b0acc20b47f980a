// SPDX-License-Identifier: MIT
#include "render/sequence_renderer.hpp"
#include "doctest/doctest.h"
#include "support/effort.hpp"

#include <cmath>
#include <dynfilter/core/error.hpp>
#include <map>
#include <memory>
#include <opencv2/core.hpp>
#include <opencv2/features2d.hpp>
#include <set>

namespace sequence_renderer_test {

using namespace dynfilter;
using namespace dynfilter::render;

namespace {

using dynfilter_test::kSlowBuild;

SequenceOptions of_scene(const std::string& scene, std::uint64_t seed = 1) {
  SequenceOptions options;
  options.scene = scene;
  options.seed = seed;
  return options;
}

/// Creating a scene takes half a second, so the tests share them.
/// Frames do not depend on earlier calls.
SequenceRenderer& shared(const std::string& scene) {
  static std::map<std::string, std::unique_ptr<SequenceRenderer>> renderers;
  auto& one = renderers[scene];
  if (!one) one = std::make_unique<SequenceRenderer>(of_scene(scene));
  return *one;
}

bool same(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() && cv::norm(a, b, cv::NORM_INF) == 0;
}

bool same(const std::vector<Detection>& a, const std::vector<Detection>& b) {
  if (a.size() != b.size()) return false;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (a[i].box != b[i].box || a[i].class_name != b[i].class_name || a[i].score != b[i].score) return false;
  }
  return true;
}

Eigen::Vector3d ray(const Camera& c, double x, double y) {
  return {(x - c.cx_px) / c.fx_px, (y - c.cy_px) / c.fy_px, 1};
}

}  // namespace

TEST_CASE("a frame depends on options, seed and number only, not on what was rendered before") {
  const SequenceOptions options = of_scene("walking_xyz");
  SequenceRenderer& first = shared("walking_xyz");
  SequenceRenderer second(options);
  RenderedFrame reused;
  second.render(11, reused);
  second.render(7, reused);
  const RenderedFrame a = first.frame(7);
  CHECK(same(a.colour, reused.colour));
  CHECK(same(a.depth, reused.depth));
  CHECK(same(a.truth.labels, reused.truth.labels));
  CHECK(same(a.truth.motion, reused.truth.motion));
  CHECK(same(a.truth.dynamic, reused.truth.dynamic));
  CHECK(same(*a.detections, *reused.detections));
  CHECK(a.timestamp_s == reused.timestamp_s);

  SequenceRenderer other(of_scene("walking_xyz", 2));
  const RenderedFrame b = other.frame(7);
  CHECK_FALSE(same(a.colour, b.colour));
  CHECK_FALSE(same(a.depth, b.depth));
}

TEST_CASE("static points of one frame are found where the next frame says, with its depth and colour") {
  SequenceOptions options = of_scene("static_desk");
  options.image_noise = 0;
  SequenceRenderer renderer(options);
  const Camera& c = renderer.camera();
  const RenderedFrame a = renderer.frame(20), b = renderer.frame(26);
  const Eigen::Isometry3d b_from_a = b.T_world_camera.isometry().inverse() * a.T_world_camera.isometry();
  REQUIRE(b_from_a.translation().norm() > 0.01);
  int depth_agrees = 0, colour_agrees = 0, tried = 0;
  for (int y = 5; y < 480; y += 5) {
    for (int x = 5; x < 640; x += 5) {
      const Eigen::Vector3d p = b_from_a * (a.true_depth_m.at<float>(y, x) * ray(c, x, y)).eval();
      const int u = cvRound(c.fx_px * p.x() / p.z() + c.cx_px),
                v = cvRound(c.fy_px * p.y() / p.z() + c.cy_px);
      if (u < 0 || v < 0 || u >= 640 || v >= 480) continue;
      ++tried;
      depth_agrees += std::abs(b.true_depth_m.at<float>(v, u) - p.z()) < 0.01 * p.z() ? 1 : 0;
      const cv::Vec3b i = a.colour.at<cv::Vec3b>(y, x), j = b.colour.at<cv::Vec3b>(v, u);
      colour_agrees += cv::norm(cv::Vec3i(i) - cv::Vec3i(j)) < 45 ? 1 : 0;
    }
  }
  CHECK(tried > 8000);
  CHECK(depth_agrees > 0.96 * tried);  // the rest is occluded, or on the other side of an edge
  CHECK(colour_agrees > 0.85 * tried);
}

TEST_CASE("labels, motion and dynamic agree with the animation of the movers") {
  SequenceRenderer& renderer = shared("walking_static");
  const int index = 30;
  const RenderedFrame frame = renderer.frame(index);
  const Camera& c = renderer.camera();
  const Eigen::Isometry3d T_world_camera = frame.T_world_camera.isometry();
  int checked = 0, moving = 0;
  for (int y = 3; y < 480; y += 7) {
    for (int x = 3; x < 640; x += 7) {
      const int label = frame.truth.labels.at<uchar>(y, x);
      const int dynamic = frame.truth.dynamic.at<uchar>(y, x);
      if (label == 0) {
        CHECK(frame.truth.motion.at<std::uint16_t>(y, x) == 0);
        CHECK(dynamic != kTruthDynamic);
        continue;
      }
      // Finds the rigid part that explains label and motion.
      // Computes its displacement directly.
      const Eigen::Vector3d now = T_world_camera * (frame.true_depth_m.at<float>(y, x) * ray(c, x, y)).eval();
      bool explained = false;
      for (const Mover& mover : renderer.scene().movers) {
        std::vector<Eigen::Isometry3d> at, last, then;
        mover.animation->pose(index / 30.0, at);
        mover.animation->pose((index - 1) / 30.0, last);
        mover.animation->pose((index - 5) / 30.0, then);
        for (std::size_t i = 0; i < at.size() && !explained; ++i) {
          if (mover.parts[i].label != label) continue;
          const Eigen::Vector3d local = at[i].inverse() * now;
          const double step_mm10 = 1e4 * (now - last[i] * local).norm();
          if (std::abs(step_mm10 - frame.truth.motion.at<std::uint16_t>(y, x)) > 1) continue;
          const Eigen::Vector3d before = T_world_camera.inverse() * (then[i] * local);
          const double miss = std::hypot(c.fx_px * before.x() / before.z() + c.cx_px - x,
                                         c.fy_px * before.y() / before.z() + c.cy_px - y);
          const bool moved = (now - then[i] * local).norm() > 0.010 && miss > 1.0;
          explained = dynamic == kTruthDontCare || (dynamic == kTruthDynamic && moved);
        }
      }
      CHECK(explained);
      ++checked;
      moving += dynamic == kTruthDynamic ? 1 : 0;
    }
  }
  CHECK(checked > 500);
  CHECK(moving > checked / 2);
}

TEST_CASE("nothing is called dynamic within five pixels of a mover's outline") {
  SequenceRenderer& renderer = shared("walking_xyz");
  const RenderedFrame frame = renderer.frame(3);
  const cv::Mat& labels = frame.truth.labels;
  int outlines = 0;
  for (int y = 6; y < 474; ++y) {
    for (int x = 6; x < 634; ++x) {
      if (labels.at<uchar>(y, x) == labels.at<uchar>(y, x + 1)) continue;
      ++outlines;
      for (int d = -5; d <= 5; ++d) {
        CHECK(frame.truth.dynamic.at<uchar>(y, x + d) == kTruthDontCare);
        CHECK(frame.truth.dynamic.at<uchar>(y + d, x) == kTruthDontCare);
      }
    }
  }
  CHECK(outlines > 300);
}

TEST_CASE(
    "the movers of majority and synchronous stand still for half a second, those of the cold starts do not") {
  for (const std::string scene : {"majority", "synchronous"}) {
    if (kSlowBuild && scene != "majority") continue;
    CAPTURE(scene);
    SequenceRenderer &waiting = shared(scene), &cold = shared(scene + "_cold");
    CHECK(cv::countNonZero(waiting.frame(14).truth.motion) == 0);
    CHECK(cv::countNonZero(waiting.frame(30).truth.dynamic == kTruthDynamic) > 20000);
    CHECK(cv::countNonZero(cold.frame(0).truth.dynamic == kTruthDynamic) > 20000);
  }
}

TEST_CASE("every scene renders, with movers where it should have some") {
  for (const std::string& name : scene_names()) {
    if (name.find("_cold") != std::string::npos) continue;  // has a test of its own
    if (kSlowBuild && name != "static_desk" && name != "walking_xyz" && name != "moving_box" &&
        name != "crowd")
      continue;
    CAPTURE(name);
    SequenceRenderer& renderer = shared(name);
    const RenderedFrame frame = renderer.frame(40);
    const bool driven_or_flown = renderer.scene().camera_model.is_stereo;
    const Camera& camera = renderer.camera();
    const cv::Size size = driven_or_flown ? cv::Size(camera.width_px, camera.height_px) : cv::Size(640, 480);
    CHECK(frame.colour.size() == size);
    CHECK(frame.colour.type() == CV_8UC3);
    CHECK(frame.depth.type() == CV_16UC1);
    CHECK(cv::countNonZero(frame.depth) > 0.6 * size.area());
    CHECK(cv::countNonZero(frame.true_depth_m) == size.area());  // the room is closed, the street has a sky
    int on_movers = cv::countNonZero(frame.truth.labels);
    if (driven_or_flown) {  // movers come and go
      on_movers += cv::countNonZero(renderer.frame(60).truth.labels);
      CHECK((on_movers == 0) == (name == "street" || name == "hall"));
      continue;
    }
    const bool empty = name.rfind("static_", 0) == 0 || name == "shake" || name.rfind("turn_", 0) == 0 ||
                       name.rfind("near_turn_", 0) == 0;
    CHECK((on_movers == 0) == empty);
    const bool people = cv::countNonZero(frame.truth.person) > 0;
    CHECK(people == (!empty && name != "moving_box" && name != "along_epipolar"));
  }
}

TEST_CASE("most features of majority lie on movers, about a third of those of walking_xyz") {
  const auto share_on_movers = [](const std::string& scene) {
    const RenderedFrame frame = shared(scene).frame(40);
    std::vector<cv::KeyPoint> features;
    cv::ORB::create(2000)->detect(frame.colour, features);
    CHECK(features.size() > 1000);
    double on_movers = 0;
    for (const cv::KeyPoint& f : features)
      on_movers += frame.truth.labels.at<uchar>(cvRound(f.pt.y), cvRound(f.pt.x)) != 0 ? 1 : 0;
    return on_movers / static_cast<double>(features.size());
  };
  CHECK(share_on_movers("majority") > 0.6);
  CHECK(share_on_movers("walking_xyz") > 0.15);
  CHECK(share_on_movers("walking_xyz") < 0.6);
}

TEST_CASE("senseless options are refused by name") {
  CHECK_THROWS_WITH_AS(SequenceRenderer{of_scene("nowhere")}, doctest::Contains("unknown scene `nowhere`"),
                       ConfigError);
  SequenceOptions options = of_scene("static_desk");
  options.frames = 0;
  CHECK_THROWS_AS(SequenceRenderer{options}, ConfigError);
}

TEST_CASE("a late detector hands over what it saw some frames ago, and nothing before its first answer") {
  SequenceOptions options = of_scene("sitting_static");
  SequenceRenderer& on_time = shared("sitting_static");
  options.detector.late_frames = 2;
  SequenceRenderer late(options);
  CHECK_FALSE(late.frame(1).detections.has_value());
  const RenderedFrame frame = late.frame(6);
  CHECK(frame.detected_on_frame == 4);
  CHECK(same(*frame.detections, *on_time.frame(4).detections));
}

TEST_CASE("exposure varies and motion blurs when asked for") {
  SequenceOptions options = of_scene("walking_rpy");
  SequenceRenderer& plain = shared("walking_rpy");
  options.exposure_variation = true;
  SequenceRenderer exposed(options);
  std::set<int> levels;
  for (int i : {0, 25, 50})
    levels.insert(cvRound(100 * cv::mean(exposed.frame(i).colour)[1] / cv::mean(plain.frame(i).colour)[1]));
  CHECK(levels.size() == 3);
  options.exposure_variation = false;
  options.motion_blur = true;
  SequenceRenderer blurred(options);
  const auto sharpness = [](const cv::Mat& colour) {
    return cv::norm(colour.colRange(1, 640), colour.colRange(0, 639), cv::NORM_L1);
  };
  CHECK(sharpness(blurred.frame(10).colour) < 0.9 * sharpness(plain.frame(10).colour));
}

}  // namespace sequence_renderer_test
