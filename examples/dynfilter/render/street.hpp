// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <dynfilter/core/random.hpp>
#include <optional>
#include <vector>

#include "render/mesh.hpp"
#include "render/street_materials.hpp"
#include "render/surroundings.hpp"
#include "render/texture.hpp"

namespace dynfilter::render {

/// A street of a town along y, with or without a crossing. It has two lanes, parked cars on both sides,
/// pavements with trees, lamps and signs, and houses. Traffic keeps to the right. z up, metres.
class Street : public Surroundings {
 public:
  static constexpr float kLane = 1.75F;      ///< middle of a lane, from the middle of the road
  static constexpr float kRoad = 3.5F;       ///< half width of both lanes
  static constexpr float kKerb = 5.8F;       ///< from the middle of the road, beyond the parked cars
  static constexpr float kHouses = 8.4F;     ///< fronts of the houses
  static constexpr float kPavement = 0.12F;  ///< height

  /// `crossing_m`: place of a crossing street on y. Instances are numbered from `first_instance` + 1.
  Street(MaterialSet& set, Random& random, std::optional<float> crossing_m, int first_instance);

 private:
  static constexpr float kBegin = -60, kEnd = 420, kPiece = 20, kSideStreet = 110;

  /// A part of a street along +y of `frame`, `length` long.
  void arm(const Eigen::Isometry3f& frame, float length);
  void road(const Eigen::Isometry3f& frame, float from, float length);
  void pavements(const Eigen::Isometry3f& frame, float from, float length);
  void houses(const Eigen::Isometry3f& frame, float side, float length);
  void parked_cars(const Eigen::Isometry3f& frame, float side, float length);
  void trees(const Eigen::Isometry3f& frame, float side, float length);
  void lamp_post(const Eigen::Isometry3f& frame, float side);
  void sign_post(const Eigen::Isometry3f& frame);
  void tree(const Eigen::Isometry3f& frame);
  void crossing(float y);
  void sky();

  Model& begin();
  float uniform(double low, double high) { return static_cast<float>(random_.uniform(low, high)); }
  template <class List>
  const auto& pick(const List& list) {
    return list[static_cast<std::size_t>(random_.below(static_cast<int>(list.size())))];
  }

  Random& random_;
  StreetMaterials m_;
  std::vector<CarPaint> paints_;
  int first_instance_;
};

}  // namespace dynfilter::render
