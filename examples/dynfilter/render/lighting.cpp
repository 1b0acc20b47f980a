// SPDX-License-Identifier: MIT
#include "render/lighting.hpp"

#include <algorithm>
#include <cmath>

namespace dynfilter::render {

// In the order of Eigen's sums, so that scenes stay bit for bit what they were with Eigen.
inline float dot(const Plain3& a, const Plain3& b) {
  return a.x * b.x + (a.y * b.y + a.z * b.z);
}
inline Plain3 difference(const Plain3& a, const Plain3& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}

Occluder::Occluder(const Eigen::Isometry3f& frame, const Eigen::Vector3f& size_m)
    : to_box_x_(frame.linear().col(0)),
      to_box_y_(frame.linear().col(1)),
      to_box_z_(frame.linear().col(2)),
      centre_m_(frame.translation()),
      half_m_(size_m / 2),
      radius_m_((size_m / 2).norm()) {}

/// Cuts (near, far) to what is between two parallel sides of a box, `half` from its centre.
inline void cut_by_sides(float half, float origin, float direction, float& near, float& far) {
  const float inverse = 1.0F / (std::abs(direction) < 1e-9F ? 1e-9F : direction);
  const float s0 = (-half - origin) * inverse, s1 = (half - origin) * inverse;
  near = std::max(near, std::min(s0, s1));
  far = std::min(far, std::max(s0, s1));
}

bool Occluder::hit(const Plain3& origin, const Plain3& direction, float far) const {
  const Plain3 o = difference(origin, centre_m_);
  float near = 0;
  cut_by_sides(half_m_.x, dot(to_box_x_, o), dot(to_box_x_, direction), near, far);
  cut_by_sides(half_m_.y, dot(to_box_y_, o), dot(to_box_y_, direction), near, far);
  cut_by_sides(half_m_.z, dot(to_box_z_, o), dot(to_box_z_, direction), near, far);
  return near < far;
}

bool Occluder::near_segment(const Plain3& from, const Plain3& along, float margin_m) const {
  const Plain3 to = difference(centre_m_, from);
  const float t = std::min(1.0F, std::max(0.0F, dot(to, along) / dot(along, along)));
  const Plain3 miss{to.x - t * along.x, to.y - t * along.y, to.z - t * along.z};
  const float reach = radius_m_ + margin_m;
  return dot(miss, miss) < reach * reach;
}

bool Occluder::near_point(const Plain3& p, float margin_m) const {
  const Plain3 to = difference(centre_m_, p);
  const float reach = radius_m_ + margin_m;
  return dot(to, to) < reach * reach;
}

bool Occluder::before_plane(const Plain3& p, const Plain3& n) const {
  const Plain3 extent{std::abs(dot(to_box_x_, n)), std::abs(dot(to_box_y_, n)), std::abs(dot(to_box_z_, n))};
  return dot(n, difference(centre_m_, p)) + dot(extent, half_m_) > 0;
}

Lighting Lighting::around(const Model& model) const {
  Lighting out;
  out.lamps = lamps;
  out.ambient = ambient;
  const Plain3 centre(model.centre_m);
  for (const Occluder& o : occluders) {
    bool matters = o.near_point(centre, model.radius_m + kReach);
    for (const Lamp& lamp : lamps) {
      const Plain3 to_lamp(lamp.position_m - model.centre_m);
      matters = matters || o.near_segment(centre, to_lamp, model.radius_m + lamp.size_m);
    }
    if (matters) out.occluders.push_back(o);
  }
  return out;
}

Eigen::Vector3f Lighting::shade(const Eigen::Vector3f& p, const Eigen::Vector3f& n, float sky_open) const {
  Eigen::Vector3f light = ambient * sky_open * (0.78F + 0.22F * n.z());
  for (const Lamp& lamp : lamps) light += lamp_light(lamp, p, n);
  return display(light);
}

Eigen::Vector3f Lighting::shade_occluded(const Eigen::Vector3f& p, const Eigen::Vector3f& n,
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
  const Plain3 from(p), normal(n);
  std::vector<const Occluder*> close;
  for (const Occluder& o : occluders) {
    if (o.near_point(from, kReach) && o.before_plane(from, normal)) close.push_back(&o);
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
    open += blocked(close, from, Plain3(d), kReach) ? 0.22F : 1.0F;
  }
  return open / kSkyRays;
}

inline float Lighting::visibility(const Lamp& lamp, const Eigen::Vector3f& p, Random& random) const {
  const Plain3 from(p), to_lamp(lamp.position_m - p);
  std::vector<const Occluder*> between;
  for (const Occluder& o : occluders) {
    if (o.near_segment(from, to_lamp, 0.5F * lamp.size_m)) between.push_back(&o);
  }
  if (between.empty()) return 1;
  int seen = 0;
  for (int i = 0; i < kLampRays; ++i) {
    const auto off = [&] { return static_cast<float>(random.uniform(-lamp.size_m, lamp.size_m)); };
    const float x = off(), y = off(), z = 0.2F * off();
    const Plain3 to_sample(lamp.position_m + Eigen::Vector3f(x, y, z) - p);
    seen += blocked(between, from, to_sample, 0.999F) ? 0 : 1;
  }
  return static_cast<float>(seen) / kLampRays;
}

inline bool Lighting::blocked(const std::vector<const Occluder*>& by, const Plain3& from, const Plain3& along,
                              float far) {
  for (const Occluder* o : by) {
    if (o->hit(from, along, far)) return true;
  }
  return false;
}

void bake(Model& model, const Lighting& lighting, Random& random) {
  const Lighting local = lighting.around(model);
  for (Vertex& v : model.vertices) v.shade = local.shade_occluded(v.position_m, v.normal, random);
}

}  // namespace dynfilter::render
