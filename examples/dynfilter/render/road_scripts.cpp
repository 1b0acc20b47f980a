// SPDX-License-Identifier: MIT
#include "render/road_scripts.hpp"

#include <cmath>
#include <memory>
#include <optional>

#include "render/hall.hpp"
#include "render/route.hpp"
#include "render/scenes.hpp"
#include "render/street.hpp"

namespace dynfilter::render::script {

namespace detail {

constexpr double kRoadExposure_ms = 2, kFlightExposure_ms = 8;
constexpr double kLane = static_cast<double>(Street::kLane);

inline std::shared_ptr<const Driving> on(const Route& route, Travel travel) {
  return std::make_shared<const Driving>(std::make_shared<const Route>(route), std::move(travel));
}

/// The lane in which the own car drives, and that of the oncoming traffic.
inline Route own_lane() {
  return Route({kLane, 0}, 0);
}
inline Route oncoming_lane() {
  return Route({-kLane, 0}, M_PI);
}

inline void outdoors(SceneBuilder& b, std::shared_ptr<const Driving> own,
                     std::optional<float> crossing_m = std::nullopt) {
  b.camera_model = kitti_camera();
  b.exposure_ms = kRoadExposure_ms;
  b.camera.style = CameraStyle::Driving;
  b.camera.drive = std::move(own);
  b.surroundings = [crossing_m](MaterialSet& set, Random& random, int first_instance) -> Surroundings {
    return Street(set, random, crossing_m, first_instance);
  };
}

/// Cars that come one after the other, the first one `first_m` ahead of the own car's start.
inline void oncoming_cars(SceneBuilder& b, double first_m, double gap_m, double speed_mps) {
  constexpr double kFarthest_m = 480;
  for (double ahead_m = first_m; ahead_m < kFarthest_m; ahead_m += gap_m * b.random().uniform(0.8, 1.3))
    b.car(on(oncoming_lane(), steady_travel(speed_mps, -ahead_m)));
}

/// An endless row of vehicles across a crossing. Buses and vans are in it, too.
inline void crossing_traffic(SceneBuilder& b, const Route& lane, double speed_mps, double gap_m,
                             bool with_buses) {
  constexpr double kBegin_m = -75, kLoop_m = 165;  // turns back where houses hide it
  constexpr double kCar_m = 4.6, kBus_m = 10.5;
  double at_m = b.random().uniform(0, 8);
  for (int i = 0; at_m < kLoop_m - kBus_m; ++i) {
    const bool bus = with_buses && i % 3 == 1;
    at_m += (bus ? kBus_m : kCar_m) / 2;
    const auto driving = on(lane, looping_travel(speed_mps, kBegin_m + at_m, kBegin_m, kLoop_m));
    if (bus)
      b.bus(driving);
    else
      b.car(driving);
    at_m += (bus ? kBus_m : kCar_m) / 2 + gap_m * b.random().uniform(0.7, 1.4);
  }
}

inline void flight(SceneBuilder& b) {
  b.camera_model = euroc_camera();
  b.exposure_ms = kFlightExposure_ms;
  b.camera.style = CameraStyle::Flying;
  b.surroundings = [](MaterialSet& set, Random& random, int first_instance) -> Surroundings {
    return Hall(set, random, first_instance);
  };
}

}  // namespace detail

void street(SceneBuilder& b) {
  detail::outdoors(b, detail::on(detail::own_lane(), city_travel(b.random().uniform(0, 2 * M_PI))));
}

void street_traffic(SceneBuilder& b) {
  street(b);
  // Two cars ahead, faster and slower than the own car in turn, but never near it.
  for (const double ahead_m : {17.0, 33.0}) {
    const Travel wander = city_travel(b.random().uniform(0, 2 * M_PI));
    b.car(detail::on(detail::own_lane(),
                     [wander, ahead_m](double time_s) { return ahead_m + wander(time_s); }));
  }
  detail::oncoming_cars(b, 30, 38, 9);
  b.walker(SceneBuilder::oval({6.9, 38}, 0.5, 11), 1.3, b.random().uniform());
  b.walker(SceneBuilder::oval({-6.9, 75}, 0.5, 11), 1.2, b.random().uniform());
}

void street_follow(SceneBuilder& b) {
  const Travel travel = city_travel(b.random().uniform(0, 2 * M_PI));
  detail::outdoors(b, detail::on(detail::own_lane(), travel));
  const double ahead_m = b.random().uniform(9, 11);
  b.car(
      detail::on(detail::own_lane(), [travel, ahead_m](double time_s) { return ahead_m + travel(time_s); }));
}

void street_oncoming(SceneBuilder& b) {
  street(b);
  detail::oncoming_cars(b, 22, 20, 10);
}

void junction(SceneBuilder& b) {
  constexpr float kCrossing_m = 60, kBefore_m = 9;
  const Route standing({detail::kLane, static_cast<double>(kCrossing_m - kBefore_m)}, 0);
  detail::outdoors(b, detail::on(standing, steady_travel(0, 0)), kCrossing_m);
  detail::crossing_traffic(b, Route({0, static_cast<double>(kCrossing_m) - detail::kLane}, -M_PI / 2), 5, 1.2,
                           false);
  detail::crossing_traffic(b, Route({0, static_cast<double>(kCrossing_m) + detail::kLane}, M_PI / 2), 6, 1.8,
                           true);
}

void street_turn(SceneBuilder& b) {
  constexpr double kCrossing_m = 60, kRadius_m = 6.5, kStart_m = 20, kArc_m = kRadius_m * M_PI / 2;
  const double straight_m = kCrossing_m - detail::kLane - kRadius_m - kStart_m;
  const Route own({detail::kLane, kStart_m}, 0, {{straight_m}, {kArc_m, -1 / kRadius_m}});
  const Travel travel = turning_travel(straight_m - 4, straight_m + kArc_m + 4);
  detail::outdoors(b, detail::on(own, travel), static_cast<float>(kCrossing_m));
  // Ahead on the same route, oncoming in the first street, and in both lanes of the second one.
  b.car(detail::on(own, [travel](double time_s) { return travel(time_s + 1.7); }));
  for (double at_m = 30; at_m < 200; at_m += b.random().uniform(24, 40))
    b.car(detail::on(detail::oncoming_lane(), steady_travel(8, -at_m)));
  for (double at_m = -20; at_m < 330; at_m += b.random().uniform(22, 40))
    b.car(detail::on(Route({0, kCrossing_m + detail::kLane}, M_PI / 2), steady_travel(8, -at_m)));
}

void hall(SceneBuilder& b) {
  detail::flight(b);
}

void hall_people(SceneBuilder& b) {
  detail::flight(b);
  const double shift = b.random().uniform();
  b.walker(SceneBuilder::oval({0, 0.5}, 1.1, 4.5), 1.3, shift);
  b.walker(SceneBuilder::oval({0.2, -1.5}, 0.9, 3.5), 1.1, shift + 0.4);
  b.walker(SceneBuilder::oval({-5.9, 4.6}, 0.4, 2.4), 1.2, shift + 0.1, true);
  b.walker(SceneBuilder::oval({5.9, -2.5}, 0.4, 2.8), 1.0, shift + 0.7);
  b.walker(SceneBuilder::oval({0, 6.0}, 4.8, 0.5), 1.4, shift + 0.3);
  b.walker(SceneBuilder::oval({0.5, 2.0}, 1.2, 3.0), 0.9, shift + 0.8);
}

}  // namespace dynfilter::render::script
