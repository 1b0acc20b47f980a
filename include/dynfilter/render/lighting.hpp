// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <dynfilter/core/random.hpp>
#include <dynfilter/render/mesh.hpp>
#include <vector>

namespace dynfilter::render {

struct Lamp {
  Eigen::Vector3f position_m;
  Eigen::Vector3f colour;  ///< BGR irradiance at one metre
  float size_m = 0.6F;     ///< half side of the cube that is sampled for soft shadows
};

/// A box that casts shadows.
class Occluder {
 public:
  /// `frame`: pose of the box in the world, with its centre as origin.
  Occluder(const Eigen::Isometry3f& frame, const Eigen::Vector3f& size_m)
      : to_box_(frame.linear().transpose()),
        centre_m_(frame.translation()),
        half_m_(size_m / 2),
        radius_m_(half_m_.norm()) {}

  /// True if origin + s * direction hits the box for some s in (near, far).
  bool hit(const Eigen::Vector3f& origin, const Eigen::Vector3f& direction, float near, float far) const;

  /// True if the bounding sphere of the box is within `margin_m` of the segment.
  bool near_segment(const Eigen::Vector3f& from, const Eigen::Vector3f& along, float margin_m) const;
  bool near_point(const Eigen::Vector3f& p, float margin_m) const;
  /// True if any part of the box is in front of the plane through p with normal n.
  bool before_plane(const Eigen::Vector3f& p, const Eigen::Vector3f& n) const {
    return n.dot(centre_m_ - p) + (to_box_ * n).cwiseAbs().dot(half_m_) > 0;
  }

 private:
  Eigen::Matrix3f to_box_;
  Eigen::Vector3f centre_m_, half_m_;
  float radius_m_;
};

/// Lambert shading of the room: lamps with soft shadows,
/// and ambient light of the room with ambient occlusion.
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

  static bool blocked(const std::vector<const Occluder*>& by, const Eigen::Vector3f& from,
                      const Eigen::Vector3f& along, float far);
};

/// Shades every vertex of a static model.
void bake(Model& model, const Lighting& lighting, Random& random);

}  // namespace dynfilter::render

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/render/detail/lighting-inl.hpp>
#endif
