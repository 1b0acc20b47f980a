// SPDX-License-Identifier: MIT
#include <cmath>
#include <cstddef>
#include <dynfilter/motion/flow_groups.hpp>
#include <dynfilter/motion/ground_contact.hpp>
#include <optional>
#include <vector>

#include "doctest/doctest.h"

namespace ground_contact_test {

using namespace dynfilter;

namespace {

/// A camera 1.65 m above a flat road that drives one step of 1 m along its axis: f = 700 px, 1200 x 380 px.
/// A point at (x, y, z) [m] right of, below and ahead of the camera has the pixel f (x, y) / z. Its inverse
/// depth is step / z.
class Road {
 public:
  static constexpr double kFocal_px = 700, kCamera_m = 1.65;

  /// Between the two depths the road shows no features.
  explicit Road(double bare_from_m = 0, double bare_to_m = 0) {
    for (double z = 6; z < 40; z *= 1.1)
      for (const double x : {-4.0, -2.5, -1.0, 0.5, 2.0, 3.5})
        if (z < bare_from_m || z > bare_to_m) add(x, kCamera_m, z, 1, true);
  }

  /// A grid of points on something upright from `foot_m` to `top_m` below the camera, 1.6 m wide. Its inverse
  /// depth seems larger by `speed_ratio`: 1 stands, 0 drives as fast as the camera, 2 comes as fast.
  std::vector<std::size_t> add_body(double x_m, double z_m, double foot_m, double top_m, double speed_ratio) {
    std::vector<std::size_t> body;
    for (int row = 0; row < 5; ++row)
      for (int column = 0; column < 5; ++column) {
        body.push_back(points_.size());
        add(x_m + 0.4 * column, top_m + (foot_m - top_m) * row / 4, z_m, speed_ratio, false);
      }
    return body;
  }

  /// Median of the standard deviations of some points; nullopt: most cannot be compared.
  std::vector<std::optional<double>> compare() {
    std::vector<cv::Point2d> places;
    for (const GroundedPoint& p : points_) places.emplace_back(p.x_px, p.y_px);
    groups_.build(places, 60, 6, 8, [&](std::size_t i, std::size_t j) {
      const GroundedPoint &p = points_[i], &q = points_[j];
      const double apart = std::abs(p.at.inverse_depth - q.at.inverse_depth) * (p.line_px + q.line_px) / 2;
      return apart < 0.4 + 0.03 * (flow_px(p) + flow_px(q));
    });
    return contact_.compare(points_, groups_, {0.2, 380, 0, 0.15, 2, 6});
  }

  /// Share of the points that are off the ground by more than 2 standard deviations.
  double off_ground(const std::vector<std::size_t>& which) {
    const auto sigmas = compare();
    REQUIRE(sigmas.size() == points_.size());
    double off = 0;
    for (const std::size_t k : which) off += sigmas[k].value_or(0) > 2 ? 1 : 0;
    return off / static_cast<double>(which.size());
  }
  std::vector<std::size_t> everything() const {
    std::vector<std::size_t> all(points_.size());
    for (std::size_t k = 0; k < all.size(); ++k) all[k] = k;
    return all;
  }
  std::vector<GroundedPoint>& points() { return points_; }
  const GroundContact& contact() const { return contact_; }

 private:
  static double flow_px(const GroundedPoint& p) { return p.at.inverse_depth * p.line_px; }

  void add(double x, double y, double z, double speed_ratio, bool ground) {
    const double u = kFocal_px * x / z, v = kFocal_px * y / z;
    const int cell = static_cast<int>(u / 100 + 6) + 12 * static_cast<int>(v / 64 + 3);
    points_.push_back({{u, v, speed_ratio / z, cell}, u, v, std::hypot(u, v), ground});
  }

  std::vector<GroundedPoint> points_;
  FlowGroups groups_;
  GroundContact contact_;
};

}  // namespace

TEST_CASE("ground_contact: the ground is found at the camera's height") {
  Road road;
  road.compare();
  REQUIRE(road.contact().ground().has_value());
  // inverse depth 1 / z at row f h / z: scale = 1 / (f h).
  CHECK(road.contact().ground()->scale ==
        doctest::Approx(1 / (Road::kFocal_px * Road::kCamera_m)).epsilon(0.02));
  CHECK(road.off_ground(road.everything()) == 0);
}

TEST_CASE("ground_contact: a car ahead that drives 0.7 times as fast or faster is beneath the ground") {
  for (const double ratio : {-0.3, 0.0, 0.3}) {
    CAPTURE(ratio);
    Road road;
    const std::vector<std::size_t> car = road.add_body(-0.8, 14, 1.6, 0.4, ratio);
    CHECK(road.off_ground(car) >= 0.9);
  }
}

TEST_CASE("ground_contact: an oncoming car hovers") {
  Road road;
  const std::vector<std::size_t> car = road.add_body(-3.6, 14, 1.6, 0.4, 2);
  CHECK(road.off_ground(car) >= 0.9);
}

TEST_CASE("ground_contact: what stands on the ground stays") {
  for (const double z_m : {8.0, 14.0, 25.0}) {
    CAPTURE(z_m);
    Road road;
    road.add_body(-3.6, z_m, 1.6, 0.4, 1);
    road.add_body(2.5, z_m, 1.6, 0.2, 1);
    CHECK(road.off_ground(road.everything()) == 0);
  }
}

TEST_CASE("ground_contact: a parked car of which only what is above the bumper shows features stays") {
  // Its lower end is a quarter of the camera's height above the road: 4/3 of the road's inverse depth in its
  // row.
  // It would stand where it is seen if it were 4/3 as far away, so the road is bare from there on.
  Road road(7.5, 11.5);
  const std::vector<std::size_t> parked = road.add_body(-3.6, 8, 0.75 * Road::kCamera_m, 0.2, 1);
  const std::vector<std::size_t> oncoming = road.add_body(2.0, 8, 0.75 * Road::kCamera_m, 0.2, 2);
  CHECK(road.off_ground(parked) == 0);
  CHECK(road.off_ground(oncoming) >= 0.9);
}

TEST_CASE("ground_contact: a parked car whose lower half is hidden by a nearer one stays") {
  Road road;
  const std::vector<std::size_t> hidden = road.add_body(2.6, 12, 0.8, 0.3, 1);
  road.add_body(2.0, 9, 1.6, 0.7, 1);
  CHECK(road.off_ground(hidden) == 0);
}

TEST_CASE("ground_contact: a road that begins to fall by 4 % is ground, too") {
  Road road;
  // From 16 m on the road falls by 4 %: its points are farther than a flat road's in the same row.
  for (GroundedPoint& p : road.points())
    if (const double z = 1 / p.at.inverse_depth; z > 16) {
      const double y = Road::kCamera_m + 0.04 * (z - 16), scale = y / Road::kCamera_m;
      p.at.y *= scale, p.y_px *= scale, p.line_px = std::hypot(p.x_px, p.y_px);
    }
  CHECK(road.off_ground(road.everything()) <= 0.02);
}

TEST_CASE("ground_contact: no ground, nothing to compare") {
  std::vector<GroundedPoint> points;
  FlowGroups groups;
  groups.build({}, 60, 6, 8, [](std::size_t, std::size_t) { return true; });
  GroundContact contact;
  CHECK(contact.compare(points, groups, {0.2, 380, 0, 0.15, 2, 6}).empty());
}

}  // namespace ground_contact_test
