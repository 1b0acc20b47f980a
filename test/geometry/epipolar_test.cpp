// SPDX-License-Identifier: MIT
#include <dynfilter/geometry/epipolar_distance.hpp>
#include <dynfilter/geometry/two_view_model.hpp>
#include <opencv2/calib3d.hpp>

#include "doctest/doctest.h"
#include "geometry/two_view_scene.hpp"

namespace epipolar_test {

using namespace dynfilter;

TEST_CASE("epipolar distance: a sideways camera has horizontal lines") {
  const Matrix9 F{0, 0, 0, 0, 0, -1, 0, 1, 0};  // [(1 0 0)]x: y2 = y1
  CHECK(epipolar_distance_px(F, {10, 20}, {400, 23}) == doctest::Approx(3));
  CHECK(geometry_test::sampson_distance_px(F, {10, 20}, {400, 23}) == doctest::Approx(3 / std::sqrt(2.0)));
  // Epipole at the origin: the line through both.
  const Matrix9 forward{0, -1, 0, 1, 0, 0, 0, 0, 0};
  CHECK(epipolar_distance_px(forward, {10, 0}, {50, 4}) == doctest::Approx(4));
  CHECK(epipolar_distance_px(forward, {0, 0}, {50, 4}) == HUGE_VAL);
}

TEST_CASE("transfer: a shift, and a change of scale") {
  const Matrix9 H{1, 0, 3, 0, 1, 4, 0, 0, 1};
  CHECK(transfer(H, {7, 7}) == cv::Point2d(10, 11));
  const Matrix9 half{1, 0, 3, 0, 1, 4, 0, 0, 2};
  CHECK(transfer(half, {7, 7}) == cv::Point2d(5, 5.5));
}

TEST_CASE("epipolar distance: static points are on their lines; OpenCV's Sampson agrees") {
  geometry_test::TwoViewRecipe recipe;
  recipe.motion = geometry_test::motion(3, {0, 1, 0}, {0.1, 0.05, 0.2});
  const geometry_test::TwoViewScene scene(recipe);
  const Matrix9 F = geometry_test::fundamental_from_pose(geometry_test::camera(), recipe.motion);
  for (int i = 0; i < 100; ++i) CHECK(epipolar_distance_px(F, scene.reference[i], scene.current[i]) < 1e-3);
  const cv::Matx33d twin(F.data());
  for (int i = 0; i < 100; ++i) {
    const cv::Point2f p = scene.reference[i], q = scene.current[i] + cv::Point2f(3, -2);
    const double squared = cv::sampsonDistance(cv::Vec3d(p.x, p.y, 1), cv::Vec3d(q.x, q.y, 1), cv::Mat(twin));
    CHECK(geometry_test::sampson_distance_px(F, p, q) == doctest::Approx(std::sqrt(squared)).epsilon(1e-6));
  }
}

TEST_CASE("distance of a homography model: the allowance acts along the line only") {
  TwoViewModel model;
  model.kind = TwoViewKind::Homography;
  model.H = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  model.F = {0, 0, 0, 0, 0, -1, 0, 1, 0};  // horizontal lines
  const double scale = std::sqrt(3.841 / 5.991);
  CHECK(distance_px(model, {5, 5}, {8, 9}) == doctest::Approx(5 * scale).epsilon(1e-4));
  model.allowance_px = 2;
  CHECK(distance_px(model, {5, 5}, {8, 5}) == doctest::Approx(scale).epsilon(1e-4));
  CHECK(distance_px(model, {5, 5}, {6, 5}) == doctest::Approx(0));
  CHECK(distance_px(model, {5, 5}, {6, 8}) == doctest::Approx(3 * scale).epsilon(1e-4));
  CHECK(judge(model, {5, 5}, {12, 5}, 1) == TwoViewVerdict::Inconsistent);
  model.ambiguous = true;
  CHECK(judge(model, {5, 5}, {12, 5}, 1) == TwoViewVerdict::CannotSay);
  CHECK(judge(model, {5, 5}, {12, 9}, 1) == TwoViewVerdict::Inconsistent);
}

}  // namespace epipolar_test
