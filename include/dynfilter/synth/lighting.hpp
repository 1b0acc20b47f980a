// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/synth/mesh.hpp>
#include <dynfilter/synth/random.hpp>
#include <vector>

namespace dynfilter::synth {

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
  bool hit(const Eigen::Vector3f& origin, const Eigen::Vector3f& direction, float near, float far) const {
    const Eigen::Vector3f o = to_box_ * (origin - centre_m_), d = to_box_ * direction;
    for (int a = 0; a < 3; ++a) {
      const float inverse = 1.0F / (std::abs(d[a]) < 1e-9F ? 1e-9F : d[a]);
      const float s0 = (-half_m_[a] - o[a]) * inverse, s1 = (half_m_[a] - o[a]) * inverse;
      near = std::max(near, std::min(s0, s1));
      far = std::min(far, std::max(s0, s1));
    }
    return near < far;
  }

  /// True if the bounding sphere of the box is within `margin_m` of the segment.
  bool near_segment(const Eigen::Vector3f& from, const Eigen::Vector3f& along, float margin_m) const {
    const Eigen::Vector3f to = centre_m_ - from;
    const float t = std::min(1.0F, std::max(0.0F, to.dot(along) / along.squaredNorm()));
    const float reach = radius_m_ + margin_m;
    return (to - t * along).squaredNorm() < reach * reach;
  }
  bool near_point(const Eigen::Vector3f& p, float margin_m) const {
    const float reach = radius_m_ + margin_m;
    return (centre_m_ - p).squaredNorm() < reach * reach;
  }
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
  Lighting around(const Model& model) const {
    Lighting out;
    out.lamps = lamps;
    out.ambient = ambient;
    for (const Occluder& o : occluders) {
      bool matters = o.near_point(model.centre_m, model.radius_m + kReach);
      for (const Lamp& lamp : lamps) {
        matters = matters || o.near_segment(model.centre_m, lamp.position_m - model.centre_m,
                                            model.radius_m + lamp.size_m);
      }
      if (matters) out.occluders.push_back(o);
    }
    return out;
  }

  /// BGR factor for the texture, with display gamma.
  /// `sky_open`: visible share of the sky and the lamps.
  Eigen::Vector3f shade(const Eigen::Vector3f& p, const Eigen::Vector3f& n, float sky_open = 1) const {
    Eigen::Vector3f light = ambient * sky_open * (0.78F + 0.22F * n.z());
    for (const Lamp& lamp : lamps) light += lamp_light(lamp, p, n);
    return display(light);
  }

  /// The same with occlusion by the furniture, for vertices of static models.
  Eigen::Vector3f shade_occluded(const Eigen::Vector3f& p, const Eigen::Vector3f& n, Random& random) const {
    const Eigen::Vector3f start = p + 0.004F * n;
    Eigen::Vector3f light = ambient * openness(start, n, random) * (0.78F + 0.22F * n.z());
    for (const Lamp& lamp : lamps) {
      if ((lamp.position_m - p).dot(n) > 0) light += lamp_light(lamp, p, n) * visibility(lamp, start, random);
    }
    return display(light);
  }

 private:
  static constexpr int kSkyRays = 14, kLampRays = 4;
  static constexpr float kReach = 1.2F;

  static Eigen::Vector3f display(const Eigen::Vector3f& light) {
    return light.cwiseMin(1.5F).array().pow(1.0F / 1.6F).matrix();
  }

  static Eigen::Vector3f lamp_light(const Lamp& lamp, const Eigen::Vector3f& p, const Eigen::Vector3f& n) {
    const Eigen::Vector3f to_lamp = lamp.position_m - p;
    const float distance2 = to_lamp.squaredNorm();
    const float wrapped = (to_lamp.dot(n) / std::sqrt(distance2) + 0.15F) / 1.15F;
    return lamp.colour * (std::max(0.0F, wrapped) / (1.0F + distance2));
  }

  float openness(const Eigen::Vector3f& p, const Eigen::Vector3f& n, Random& random) const {
    std::vector<const Occluder*> close;
    for (const Occluder& o : occluders) {
      if (o.near_point(p, kReach) && o.before_plane(p, n)) close.push_back(&o);
    }
    if (close.empty()) return 1;
    float open = 0;
    for (int i = 0; i < kSkyRays; ++i) {
      // Directions n + unit vector are cosine-distributed (golden spiral, randomly rotated).
      const float z = 1.0F - (2.0F * static_cast<float>(i) + 1.0F) / kSkyRays;
      const float angle = 2.39996F * static_cast<float>(i) + static_cast<float>(random.uniform(0, 0.4));
      const float r = std::sqrt(1 - z * z);
      const Eigen::Vector3f d =
          (n * 1.001F + Eigen::Vector3f(r * std::cos(angle), r * std::sin(angle), z)).normalized();
      open += blocked(close, p, d, kReach) ? 0.22F : 1.0F;
    }
    return open / kSkyRays;
  }

  float visibility(const Lamp& lamp, const Eigen::Vector3f& p, Random& random) const {
    std::vector<const Occluder*> between;
    for (const Occluder& o : occluders) {
      if (o.near_segment(p, lamp.position_m - p, 0.5F * lamp.size_m)) between.push_back(&o);
    }
    if (between.empty()) return 1;
    int seen = 0;
    for (int i = 0; i < kLampRays; ++i) {
      const auto off = [&] { return static_cast<float>(random.uniform(-lamp.size_m, lamp.size_m)); };
      const float x = off(), y = off(), z = 0.2F * off();
      seen += blocked(between, p, lamp.position_m + Eigen::Vector3f(x, y, z) - p, 0.999F) ? 0 : 1;
    }
    return static_cast<float>(seen) / kLampRays;
  }

  static bool blocked(const std::vector<const Occluder*>& by, const Eigen::Vector3f& from,
                      const Eigen::Vector3f& along, float far) {
    for (const Occluder* o : by) {
      if (o->hit(from, along, 0.0F, far)) return true;
    }
    return false;
  }
};

/// Shades every vertex of a static model.
inline void bake(Model& model, const Lighting& lighting, Random& random) {
  const Lighting local = lighting.around(model);
  for (Vertex& v : model.vertices) v.shade = local.shade_occluded(v.position_m, v.normal, random);
}

}  // namespace dynfilter::synth
