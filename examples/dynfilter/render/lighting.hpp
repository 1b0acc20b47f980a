// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <dynfilter/core/random.hpp>
#include <vector>

#include "render/mesh.hpp"

namespace dynfilter::render {

struct Lamp {
  Eigen::Vector3f position_m;
  Eigen::Vector3f colour;  ///< BGR irradiance at one metre
  float size_m = 0.6F;     ///< half side of the cube that is sampled for soft shadows
};

/// A point or a direction as plain numbers. A room asks for millions of shadows:
/// Eigen's expressions take several times as long where nothing is inlined, as under the sanitizers.
struct Plain3 {
  float x, y, z;

  explicit Plain3(const Eigen::Vector3f& v) : x(v.x()), y(v.y()), z(v.z()) {}
  Plain3(float x_, float y_, float z_) : x(x_), y(y_), z(z_) {}
};

/// A box that casts shadows.
class Occluder {
 public:
  /// `frame`: pose of the box in the world, with its centre as origin.
  Occluder(const Eigen::Isometry3f& frame, const Eigen::Vector3f& size_m);

  /// True if origin + s * direction hits the box for some s in (0, far).
  bool hit(const Plain3& origin, const Plain3& direction, float far) const;

  /// True if the bounding sphere of the box is within `margin_m` of the segment.
  bool near_segment(const Plain3& from, const Plain3& along, float margin_m) const;
  bool near_point(const Plain3& p, float margin_m) const;
  /// True if any part of the box is in front of the plane through p with normal n.
  bool before_plane(const Plain3& p, const Plain3& n) const;

 private:
  Plain3 to_box_x_, to_box_y_, to_box_z_;  ///< rows of the rotation from the world to the box
  Plain3 centre_m_, half_m_;
  float radius_m_;
};

/// Lambert shading of the room: lamps with soft shadows, and ambient light of the room with ambient
/// occlusion.
class Lighting {
 public:
  std::vector<Lamp> lamps;
  std::vector<Occluder> occluders;
  Eigen::Vector3f ambient{0.50F, 0.47F, 0.45F};

  /// The same light with only the occluders that can affect a model.
  Lighting around(const Model& model) const;

  /// BGR factor for the texture, with display gamma.
  /// `sky_open`: visible share of the sky and the lamps.
  Eigen::Vector3f shade(const Eigen::Vector3f& p, const Eigen::Vector3f& n, float sky_open = 1) const;

  /// The same with occlusion by the furniture, for vertices of static models.
  Eigen::Vector3f shade_occluded(const Eigen::Vector3f& p, const Eigen::Vector3f& n, Random& random) const;

 private:
  static constexpr int kSkyRays = 14, kLampRays = 4;
  static constexpr float kReach = 1.2F;

  static Eigen::Vector3f display(const Eigen::Vector3f& light) {
    return light.cwiseMin(1.5F).array().pow(1.0F / 1.6F).matrix();
  }

  static Eigen::Vector3f lamp_light(const Lamp& lamp, const Eigen::Vector3f& p, const Eigen::Vector3f& n);

  float openness(const Eigen::Vector3f& p, const Eigen::Vector3f& n, Random& random) const;

  float visibility(const Lamp& lamp, const Eigen::Vector3f& p, Random& random) const;

  static bool blocked(const std::vector<const Occluder*>& by, const Plain3& from, const Plain3& along,
                      float far);
};

/// Shades every vertex of a static model.
void bake(Model& model, const Lighting& lighting, Random& random);

}  // namespace dynfilter::render
