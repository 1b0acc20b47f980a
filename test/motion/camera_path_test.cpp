// SPDX-License-Identifier: MIT
#include <cmath>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/motion/camera_path.hpp>

#include "doctest/doctest.h"

namespace camera_path_test {

using namespace dynfilter;
using doctest::Approx;

namespace {

FrameView frame(std::int64_t id, double timestamp_s) {
  FrameView view;
  view.id = id;
  view.timestamp_s = timestamp_s;
  return view;
}

Pose turn(double angle_rad, double x_m) {
  return Pose::from(rotation_about(Eigen::Vector3d::UnitY(), angle_rad), Eigen::Vector3d(x_m, 0, 0));
}

/// A camera that makes the same step in every frame.
CameraPath driven(int frames, double hz, const Pose& step, double noise_px = 0.1) {
  CameraPath path;
  for (int k = 0; k < frames; ++k) {
    path.begin(frame(10 + k, k / hz));
    if (k > 0) path.add(step, {noise_px, {}}), path.chain(true);
  }
  return path;
}

}  // namespace

TEST_CASE("camera path: the motion over a gap is that of its steps, one after the other") {
  const Pose step = turn(0.02, 0.1);
  const CameraPath path = driven(5, 30, step);
  Pose sum;
  for (std::size_t gap = 0; gap <= path.steps(); ++gap, sum = step * sum) {
    CHECK((path.between(0, gap).R() - sum.R()).norm() < 1e-12);
    CHECK((path.between(0, gap).t() - sum.t()).norm() < 1e-12);
  }
  CHECK((path.usual_step().R() - step.R()).norm() < 1e-12);
}

TEST_CASE("camera path: it goes back 0.2 s, at least two steps and at most twelve") {
  CHECK(driven(40, 30, turn(0, 0)).steps() == 6);
  CHECK(driven(40, 10, turn(0, 0)).steps() == 2);
  CHECK(driven(40, 5, turn(0, 0)).steps() == 2);
  CHECK(driven(40, 100, turn(0, 0)).steps() == CameraPath::kMaxFrames);
  CHECK(driven(3, 30, turn(0, 0)).steps() == 2);
  CHECK(driven(1, 30, turn(0, 0)).steps() == 0);
}

TEST_CASE("camera path: noise of independent steps adds up as variances") {
  const CameraPath path = driven(10, 30, turn(0, 0), 0.12);
  const double one_px = std::sqrt(0.12 * 0.12 + 0.05 * 0.05);  // flow is not more exact than 0.05 px
  CHECK(path.noise_px(1) == Approx(one_px));
  CHECK(path.noise_px(4) == Approx(2 * one_px));
}

TEST_CASE("camera path: twists of the rows add up over a gap") {
  CameraPath path;
  for (int k = 0; k < 4; ++k) {
    path.begin(frame(k, k / 30.0));
    RowTwist twist;
    twist.a_rad = Eigen::Vector3d(0, 0.001 * k, 0);
    if (k > 0) path.add(Pose(), {0.1, twist});
  }
  CHECK(path.twist(1).a_rad.y() == Approx(0.003));
  CHECK(path.twist(3).a_rad.y() == Approx(0.006));
}

TEST_CASE("camera path: times and names of frames; stamps that do not increase count as 30 Hz") {
  CameraPath path = driven(4, 20, turn(0, 0));
  CHECK(path.elapsed_s(1) == Approx(0.05));
  CHECK(path.elapsed_s(3) == Approx(0.15));
  CHECK(path.elapsed_s(9) == Approx(9 / 30.0));  // longer ago than it knows
  CHECK(path.frame_id(0) == 13);
  CHECK(path.is_last_frame(12));
  CHECK_FALSE(path.is_last_frame(11));
  path.begin(frame(14, 3 / 20.0));
  CHECK(path.elapsed_s(1) == Approx(1 / 30.0));
}

TEST_CASE("camera path: the rate of turn is that of the last known step, while a frame is judged") {
  CameraPath path = driven(4, 20, turn(0.03, 0));
  path.begin(frame(14, 0.2));
  CHECK(path.last_turn_radps().y() == Approx(0.03 * 20));
}

TEST_CASE("camera path: a step that is not sure breaks the chain; forgetting keeps the times") {
  CameraPath path = driven(6, 30, turn(0.01, 0));
  CHECK(path.unbroken() == 5);
  path.chain(false);
  CHECK(path.unbroken() == 0);
  CHECK(path.steps() == 5);
  path.forget_motion();
  CHECK(path.steps() == 0);
  CHECK(path.elapsed_s(1) == Approx(1 / 30.0));
  path.reset();
  CHECK_FALSE(path.is_last_frame(14));
}

}  // namespace camera_path_test
