// SPDX-License-Identifier: MIT
#include <algorithm>
#include <dynfilter/motion/mover_forecast.hpp>
#include <limits>
#include <vector>

#include "doctest/doctest.h"

namespace mover_forecast_test {

using namespace dynfilter;
using Seen = MoverForecast::Seen;

namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
const cv::Point3f kUnknown(kNan, kNan, kNan);

Camera camera() {
  Camera c;
  c.fx_px = c.fy_px = 700;
  c.cx_px = 600, c.cy_px = 180;
  c.width_px = 1240, c.height_px = 370;
  return c;
}
cv::Point2f pixel(const cv::Point3f& point_m) {
  return {700 * point_m.x / point_m.z + 600, 700 * point_m.y / point_m.z + 180};
}
/// Two features of a car in one cell of 2 m.
std::vector<Seen> car(const cv::Point3f& at_m, const cv::Point3f& velocity_mps) {
  return {{at_m, velocity_mps, 8, true}, {at_m + cv::Point3f(0.2F, 0, 0), velocity_mps, 8, true}};
}
const Pose kStill = Pose::from(Eigen::Matrix3d::Identity(), Eigen::Vector3d::Zero());
constexpr float kNear_m = 0.5F;
const cv::Point3f kAt_m(-1.8F, 0.5F, 10.5F), kVelocity_mps(0, 0, -15);

}  // namespace

TEST_CASE("mover_forecast: a mover is expected where its velocity takes it") {
  MoverForecast forecast;
  forecast.learn(car(kAt_m, kVelocity_mps));
  forecast.advance(kStill, camera(), 0.1);
  const cv::Point3f there_m(-1.8F, 0.5F, 9);
  CHECK(forecast.expects());
  CHECK(forecast.evidence(pixel(there_m), 9, kNear_m) == 8.0F);
  CHECK(forecast.evidence(pixel(there_m), 10.5F, kNear_m) == 0.0F);  // another depth
  CHECK(forecast.evidence(pixel(there_m) + cv::Point2f(300, 0), 9, kNear_m) == 0.0F);
  const float blind = forecast.evidence(pixel(there_m), kNan, kNear_m);
  CHECK(blind > 0.0F);
  CHECK(blind < 8.0F);  // it may lie on what is behind
  forecast.clear();
  CHECK_FALSE(forecast.expects());
  CHECK(forecast.evidence(pixel(there_m), 9, kNear_m) == 0.0F);
}

TEST_CASE("mover_forecast: the camera's motion is undone") {
  MoverForecast forecast;
  forecast.learn(car(kAt_m, kVelocity_mps));
  // The camera moves 1 m forwards: what stands still comes 1 m nearer.
  forecast.advance(Pose::from(Eigen::Matrix3d::Identity(), Eigen::Vector3d(0, 0, -1)), camera(), 0.1);
  CHECK(forecast.evidence(pixel({-1.8F, 0.5F, 8}), 8, kNear_m) > 5.0F);
  CHECK(forecast.evidence(pixel({-1.8F, 0.5F, 9}), 9, kNear_m) == 0.0F);
}

TEST_CASE("mover_forecast: the same at 10 and at 30 Hz, without a measured velocity in between") {
  MoverForecast once, often;
  once.learn(car(kAt_m, kVelocity_mps));
  often.learn(car(kAt_m, kVelocity_mps));
  once.advance(kStill, camera(), 0.1);
  for (int k = 1; k <= 3; ++k) {
    often.advance(kStill, camera(), 0.1 / 3);
    const float z_m = 10.5F - 0.5F * static_cast<float>(k);
    const float evidence = often.evidence(pixel({-1.8F, 0.5F, z_m}), z_m, kNear_m);
    CHECK(evidence == 8.0F);
    std::vector<Seen> unmatched = car({-1.8F, 0.5F, z_m}, kUnknown);
    for (Seen& seen : unmatched) seen.evidence = evidence;
    if (k < 3) often.learn(unmatched);
  }
  CHECK(often.evidence(pixel({-1.8F, 0.5F, 9}), 9, kNear_m) ==
        once.evidence(pixel({-1.8F, 0.5F, 9}), 9, kNear_m));
}

TEST_CASE("mover_forecast: one measured velocity may be a mismatch, a median is not led astray by one") {
  MoverForecast forecast;
  forecast.learn({{kAt_m, kVelocity_mps, 8, true}});
  forecast.advance(kStill, camera(), 0.1);
  CHECK(forecast.evidence(pixel({-1.8F, 0.5F, 9}), 9, kNear_m) == 0.0F);
  CHECK(forecast.evidence(pixel(kAt_m), kAt_m.z, kNear_m) == 0.0F);

  std::vector<Seen> seen = car(kAt_m, kVelocity_mps);
  seen.push_back({kAt_m, {200, 200, 200}, 8, true});
  forecast.learn(seen);
  forecast.advance(kStill, camera(), 0.1);
  CHECK(forecast.evidence(pixel({-1.8F, 0.5F, 9}), 9, kNear_m) > 5.0F);
}

TEST_CASE("mover_forecast: what stands still beside a mover lowers what is expected of its surroundings") {
  std::vector<Seen> seen = car(kAt_m, {0, 0, 0.01F});
  MoverForecast alone, among;
  alone.learn(seen);
  for (int k = 0; k < 6; ++k) seen.push_back({kAt_m, kUnknown, -4, false});
  among.learn(seen);
  for (MoverForecast* forecast : {&alone, &among}) forecast->advance(kStill, camera(), 0.1);
  CHECK(alone.evidence(pixel(kAt_m), kAt_m.z, kNear_m) > 5.0F);
  CHECK(among.evidence(pixel(kAt_m), kAt_m.z, kNear_m) < 0.0F);
}

TEST_CASE("mover_forecast: the order of the features does not matter, and odd points are nowhere") {
  std::vector<Seen> seen = car(kAt_m, kVelocity_mps);
  for (int k = 0; k < 5; ++k)
    seen.push_back({kAt_m + cv::Point3f(0.03F * static_cast<float>(k), 0, 0),
                    kVelocity_mps * (1 + 0.01F * static_cast<float>(k)), 2.0F + static_cast<float>(k), true});
  seen.push_back({{0, 0, 0.5F}, {0, 0, -10}, 8, true});  // passes behind the camera
  seen.push_back({{0.1F, 0, 0.5F}, {0, 0, -10}, 8, true});
  std::vector<Seen> turned(seen.rbegin(), seen.rend());
  MoverForecast a, b;
  a.learn(seen), b.learn(turned);
  a.advance(kStill, camera(), 0.1), b.advance(kStill, camera(), 0.1);
  for (float x_px = 0; x_px < 1240; x_px += 7)
    CHECK(a.evidence({x_px, 200}, 9, 1) == b.evidence({x_px, 200}, 9, 1));
}

}  // namespace mover_forecast_test
