// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/render/lighting.hpp>

#include <algorithm>
#include <cmath>
#include <dynfilter/core/inline.hpp>

namespace dynfilter::render {

DYNFILTER_INLINE bool Occluder::hit(const Eigen::Vector3f& origin, const Eigen::Vector3f& direction,
                                    float near, float far) const {
  const Eigen::Vector3f o = to_box_ * (origin - centre_m_), d = to_box_ * direction;
  for (int a = 0; a < 3; ++a) {
    const float inverse = 1.0F / (std::abs(d[a]) < 1e-9F ? 1e-9F : d[a]);
    const float s0 = (-half_m_[a] - o[a]) * inverse, s1 = (half_m_[a] - o[a]) * inverse;
    near = std::max(near, std::min(s0, s1));
    far = std::min(far, std::max(s0, s1));
  }
  return near < far;
}

DYNFILTER_INLINE bool Occluder::near_segment(const Eigen::Vector3f& from, const Eigen::Vector3f& along,
                                             float margin_m) const {
  const Eigen::Vector3f to = centre_m_ - from;
  const float t = std::min(1.0F, std::max(0.0F, to.dot(along) / along.squaredNorm()));
  const float reach = radius_m_ + margin_m;
  return (to - t * along).squaredNorm() < reach * reach;
}

DYNFILTER_INLINE bool Occluder::near_point(const Eigen::Vector3f& p, float margin_m) const {
  const float reach = radius_m_ + margin_m;
  return (centre_m_ - p).squaredNorm() < reach * reach;
}

DYNFILTER_INLINE Lighting Lighting::around(const Model& model) const {
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

DYNFILTER_INLINE Eigen::Vector3f Lighting::shade(const Eigen::Vector3f& p, const Eigen::Vector3f& n,
                                                 float sky_open) const {
  Eigen::Vector3f light = ambient * sky_open * (0.78F + 0.22F * n.z());
  for (const Lamp& lamp : lamps) light += lamp_light(lamp, p, n);
  return display(light);
}

DYNFILTER_INLINE Eigen::Vector3f Lighting::shade_occluded(const Eigen::Vector3f& p, const Eigen::Vector3f& n,
                                                          Random& random) const {
  const Eigen::Vector3f start = p + 0.004F * n;
  Eigen::Vector3f light = ambient * openness(start, n, random) * (0.78F + 0.22F * n.z());
  for (const Lamp& lamp : lamps) {
    if ((lamp.position_m - p).dot(n) > 0) light += lamp_light(lamp, p, n) * visibility(lamp, start, random);
  }
  return display(light);
}

inline Eigen::Vector3f Lighting::lamp_light(const Lamp& lamp, const Eigen::Vector3f& p,
                                            const Eigen::Vector3f& n) {
  const Eigen::Vector3f to_lamp = lamp.position_m - p;
  const float distance2 = to_lamp.squaredNorm();
  const float wrapped = (to_lamp.dot(n) / std::sqrt(distance2) + 0.15F) / 1.15F;
  return lamp.colour * (std::max(0.0F, wrapped) / (1.0F + distance2));
}

inline float Lighting::openness(const Eigen::Vector3f& p, const Eigen::Vector3f& n, Random& random) const {
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

inline float Lighting::visibility(const Lamp& lamp, const Eigen::Vector3f& p, Random& random) const {
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

inline bool Lighting::blocked(const std::vector<const Occluder*>& by, const Eigen::Vector3f& from,
                              const Eigen::Vector3f& along, float far) {
  for (const Occluder* o : by) {
    if (o->hit(from, along, 0.0F, far)) return true;
  }
  return false;
}

DYNFILTER_INLINE void bake(Model& model, const Lighting& lighting, Random& random) {
  const Lighting local = lighting.around(model);
  for (Vertex& v : model.vertices) v.shade = local.shade_occluded(v.position_m, v.normal, random);
}

}  // namespace dynfilter::render
