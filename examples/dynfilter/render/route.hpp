// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <vector>

#include "render/motion.hpp"

namespace dynfilter::render {

/// A lane: straight pieces and arcs, by arc length. Straight on before its begin and after its end.
class Route {
 public:
  struct Piece {
    double length_m;
    double curvature_per_m = 0;  ///< positive: to the left
  };

  /// `heading_rad`: 0 is north (+y), growing to the left.
  Route(const Eigen::Vector2d& start, double heading_rad, std::vector<Piece> pieces = {});

  Eigen::Vector2d at(double s_m) const { return place(s_m).at; }
  double heading_rad(double s_m) const { return place(s_m).heading_rad; }

 private:
  struct Place {
    Eigen::Vector2d at;
    double heading_rad;
  };

  static Place moved(const Place& from, double length_m, double curvature_per_m);

  Place place(double s_m) const;

  std::vector<Piece> pieces_;
  std::vector<Place> starts_;  ///< of each piece
  Place end_;
};

/// Distance travelled on a route at a time [s].
using Travel = std::function<double(double)>;

/// About 11 m/s, between 8 and 14 m/s. Different per phase.
Travel city_travel(double phase_rad);

/// Constant speed from `offset_m` at time 0.
Travel steady_travel(double speed_mps, double offset_m);

/// The same, and back to `begin_m` after every `loop_m`.
Travel looping_travel(double speed_mps, double offset_m, double begin_m, double loop_m);

/// 9 m/s, and 4.5 m/s between two places of the route.
Travel turning_travel(double slow_from_m, double slow_to_m);

/// A car on a route.
class Driving : public Animation {
 public:
  Driving(std::shared_ptr<const Route> route, Travel travel)
      : route_(std::move(route)), travel_(std::move(travel)) {}

  void pose(double time_s, std::vector<Eigen::Isometry3d>& parts) const override;
  /// On the road below the middle of the car; y ahead, z up.
  Eigen::Isometry3d pose(double time_s) const;

 private:
  std::shared_ptr<const Route> route_;
  Travel travel_;
};

}  // namespace dynfilter::render
