// SPDX-License-Identifier: MIT
#include "render/street.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>

#include "render/car.hpp"
#include "render/furniture.hpp"

namespace dynfilter::render {

Street::Street(MaterialSet& set, Random& random, std::optional<float> crossing_m, int first_instance)
    : random_(random), m_(set, random), first_instance_(first_instance) {
  constexpr int kPaints = 7;
  for (int i = 0; i < kPaints; ++i) paints_.emplace_back(set, random);
  const auto along = [](float x, float y, double yaw_rad) {
    return placed({x, y, 0}, static_cast<float>(yaw_rad));
  };
  if (crossing_m) {
    const float y = *crossing_m;
    arm(along(0, y - kHouses, CV_PI), y - kHouses - kBegin);
    arm(along(0, y + kHouses, 0), kEnd - y - kHouses);
    arm(along(kHouses, y, -CV_PI / 2), 3 * kSideStreet);
    arm(along(-kHouses, y, CV_PI / 2), kSideStreet);
    crossing(y);
  } else {
    arm(along(0, kBegin, 0), kEnd - kBegin);
  }
  sky();
  // The sun is behind the camera, to the right and high.
  const Eigen::Vector3f sun(420, -500, 760);
  lighting.lamps = {{sun, Eigen::Vector3f(0.98F, 1.08F, 1.14F) * (1 + sun.squaredNorm()), 9.0F}};
  lighting.ambient = {0.66F, 0.60F, 0.55F};
  for (Model& model : models) {
    model.finish();
    bake(model, lighting, random);
  }
}

inline Model& Street::begin() {
  models.emplace_back();
  return models.back();
}

inline void Street::arm(const Eigen::Isometry3f& frame, float length) {
  for (float from = 0; from < length; from += kPiece) {
    const float piece = std::min(kPiece, length - from);
    road(frame, from, piece);
    pavements(frame, from, piece);
  }
  for (const float side : {-1.0F, 1.0F}) {
    houses(frame, side, length);
    parked_cars(frame, side, length);
    trees(frame, side, length);
  }
}

inline void Street::road(const Eigen::Isometry3f& frame, float from, float length) {
  constexpr float kAbove = 0.012F;  // of paint over asphalt
  const auto at = [&](float x, float y, float z) -> Eigen::Vector3f {
    return frame * Eigen::Vector3f(x, y, z);
  };
  const auto along = [&](float x, float y, float z) -> Eigen::Vector3f {
    return frame.linear() * Eigen::Vector3f(x, y, z);
  };
  Model& model = begin();
  add_rectangle(model, {at(-kKerb, from + length, 0), along(2 * kKerb, 0, 0), along(0, -length, 0)},
                {m_.asphalt, 6.0F}, 0.9F);
  const auto line = [&](float x, float y, float wide, float long_m) {
    add_rectangle(model, {at(x - wide / 2, y + long_m, kAbove), along(wide, 0, 0), along(0, -long_m, 0)},
                  {m_.marking, 0.8F}, 2.0F);
  };
  for (float y = from; y + 3 < from + length; y += 6) line(0, y, 0.14F, 3);
  for (const float x : {-kRoad, kRoad}) line(x, from, 0.1F, length);
}

inline void Street::pavements(const Eigen::Isometry3f& frame, float from, float length) {
  Model& model = begin();
  const float wide = kHouses - kKerb;
  BoxSkin skin = BoxSkin::all({m_.kerb, 0.8F});
  skin.top = {m_.paving, 1.6F};
  skin.bottom.material = kNoSkin;
  for (const float side : {-1.0F, 1.0F})
    add_box(model, frame * placed({side * (kKerb + wide / 2), from + length / 2, kPavement / 2}, 0),
            {wide, length, kPavement}, skin, 0.9F);
}

inline void Street::houses(const Eigen::Isometry3f& frame, float side, float length) {
  for (float y = 0; y < length;) {
    const float wide = uniform(8, 14), high = uniform(7.5, 12), deep = 9, back = uniform(0, 0.5);
    BoxSkin skin = BoxSkin::all({m_.plain_wall, 4.0F});
    // A front towards the road: that of a box is at -y of its frame.
    skin.front = {pick(m_.facades)};
    skin.top = {m_.roof, 3.0F};
    skin.bottom.material = kNoSkin;
    const Eigen::Isometry3f box = frame * placed({side * (kHouses + back + deep / 2), y + wide / 2, high / 2},
                                                 side * static_cast<float>(-CV_PI / 2));
    const Eigen::Vector3f size(wide, deep, high);
    add_box(begin(), box, size, skin, 1.6F);
    lighting.occluders.emplace_back(box, size);
    y += wide + (random_.chance(0.25) ? uniform(1.5, 4) : 0.0F);
  }
}

inline void Street::parked_cars(const Eigen::Isometry3f& frame, float side, float length) {
  constexpr float kFree = 6;  // at both ends
  for (float y = kFree; y + kFree < length; y += uniform(5.6, 7.2)) {
    if (random_.chance(0.22)) continue;  // a free space
    const CarKind kind = random_.chance(0.15)  ? CarKind::Van
                         : random_.chance(0.5) ? CarKind::Saloon
                                               : CarKind::Hatchback;
    objects.push_back({2, "car"});
    const int instance = first_instance_ + static_cast<int>(objects.size());
    const float yaw = side > 0 ? 0 : static_cast<float>(CV_PI);
    const float parked_yaw = yaw + uniform(-0.03, 0.03);
    const Eigen::Isometry3f at =
        frame * placed({side * (kRoad + 1.2F + uniform(-0.12, 0.12)), y, 0}, parked_yaw);
    Model car = car_model(pick(paints_), kind, instance);
    for (Vertex& v : car.vertices) {
      v.position_m = at * v.position_m;
      v.normal = at.linear() * v.normal;
    }
    models.push_back(std::move(car));
    lighting.occluders.emplace_back(at * placed({0, 0, 0.75F}, 0), Eigen::Vector3f(1.6F, 3.9F, 0.9F));
  }
}

inline void Street::trees(const Eigen::Isometry3f& frame, float side, float length) {
  const float x = side * (kKerb + 0.7F);
  for (float y = uniform(2, 8); y + 3 < length; y += uniform(7, 12)) {
    const Eigen::Isometry3f at = frame * placed({x, y, kPavement}, uniform(0, 6));
    const double what = random_.uniform();
    if (what < 0.6)
      tree(at);
    else if (what < 0.85)
      lamp_post(frame * placed({x, y, kPavement}, 0), side);
    else
      sign_post(frame * placed({x, y, kPavement}, 0));
  }
}

inline void Street::tree(const Eigen::Isometry3f& frame) {
  Model& model = begin();
  const float high = uniform(2.4, 3.2), crown = uniform(1.3, 1.9);
  add_loft(model, frame, {{high + 1, 0, 0, 0.07F, 0.07F}, {high, 0, 0, 0.1F, 0.1F}, {0, 0, 0, 0.16F, 0.16F}},
           {m_.bark, 1, 3, 9});
  const int leaves = pick(m_.foliage);
  for (int i = 0; i < 5; ++i) {
    const float angle = 1.3F * static_cast<float>(i) * static_cast<float>(CV_PI) / 2,
                off = i == 0 ? 0 : 0.55F * crown;
    const Eigen::Vector3f centre(off * std::cos(angle), off * std::sin(angle),
                                 high + crown * uniform(0.5, 1.1));
    const float r = crown * uniform(0.6, 0.85);
    add_loft(model, frame, ellipsoid_rings(centre, {r, r, 0.85F * r}, 7), {leaves, 2, 1, 12});
  }
  lighting.occluders.emplace_back(frame * placed({0, 0, high + crown * 0.8F}, 0),
                                  Eigen::Vector3f(1.5F * crown, 1.5F * crown, 1.2F * crown));
}

inline void Street::lamp_post(const Eigen::Isometry3f& frame, float side) {
  Model& model = begin();
  const BoxSkin skin = BoxSkin::all({m_.metal, 0.6F});
  add_loft(model, frame, {{5.5F, 0, 0, 0.05F, 0.05F}, {0, 0, 0, 0.09F, 0.09F}}, {m_.metal, 1, 6, 8});
  add_box(model, frame * placed({-side * 0.7F, 0, 5.5F}, 0), {1.5F, 0.07F, 0.07F}, skin);
  add_box(model, frame * placed({-side * 1.4F, 0, 5.44F}, 0), {0.6F, 0.2F, 0.1F}, skin);
}

inline void Street::sign_post(const Eigen::Isometry3f& frame) {
  Model& model = begin();
  BoxSkin skin = BoxSkin::all({m_.metal, 0.6F});
  add_box(model, frame * placed({0, 0, 1.2F}, 0), {0.07F, 0.07F, 2.4F}, skin);
  skin.front = {pick(m_.signs)};
  add_box(model, frame * placed({0, -0.05F, 2.3F}, 0), {0.62F, 0.03F, 0.62F}, skin);
}

inline void Street::crossing(float y) {
  for (float from = -kHouses; from < kHouses; from += kHouses) {
    Model& model = begin();
    add_rectangle(model, {{-kHouses, y + from + kHouses, 0}, {2 * kHouses, 0, 0}, {0, -kHouses, 0}},
                  {m_.asphalt, 6.0F}, 0.9F);
  }
  Model& model = begin();  // corners of the pavements
  const float wide = kHouses - kKerb, middle = (kHouses + kKerb) / 2;
  BoxSkin skin = BoxSkin::all({m_.kerb, 0.8F});
  skin.top = {m_.paving, 1.6F};
  skin.bottom.material = kNoSkin;
  for (const float sx : {-1.0F, 1.0F})
    for (const float sy : {-1.0F, 1.0F})
      add_box(model, placed({sx * middle, y + sy * middle, kPavement / 2}, 0), {wide, wide, kPavement}, skin,
              0.9F);
  // Stop lines.
  constexpr float kAbove = 0.012F, kWide = 0.4F;
  add_rectangle(model, {{0.1F, y - kHouses + kWide, kAbove}, {kRoad - 0.1F, 0, 0}, {0, -kWide, 0}},
                {m_.marking, 0.8F}, 2.0F);
  add_rectangle(model, {{-kRoad, y + kHouses, kAbove}, {kRoad - 0.1F, 0, 0}, {0, -kWide, 0}},
                {m_.marking, 0.8F}, 2.0F);
}

inline void Street::sky() {
  // Farther than any depth image, near enough for the rasteriser.
  constexpr float kFar = 700, kHigh = 500;
  const float middle = (kBegin + kEnd) / 2;
  Model& walls = begin();
  const Skin skin{m_.sky};
  const Eigen::Vector3f down(0, 0, -kHigh - 20);
  const float w = -kFar, e = kFar, s = middle - kFar, n = middle + kFar;
  add_rectangle(walls, {{w, n, kHigh}, {2 * kFar, 0, 0}, down}, skin, 4 * kFar);
  add_rectangle(walls, {{e, s, kHigh}, {-2 * kFar, 0, 0}, down}, skin, 4 * kFar);
  add_rectangle(walls, {{w, s, kHigh}, {0, 2 * kFar, 0}, down}, skin, 4 * kFar);
  add_rectangle(walls, {{e, n, kHigh}, {0, -2 * kFar, 0}, down}, skin, 4 * kFar);
  add_rectangle(begin(), {{w, s, kHigh}, {2 * kFar, 0, 0}, {0, 2 * kFar, 0}}, {m_.sky_top}, 4 * kFar);
  Model& land = begin();  // beyond the houses
  add_rectangle(land, {{w, n, -0.4F}, {2 * kFar, 0, 0}, {0, -2 * kFar, 0}}, {m_.foliage[0], 12.0F}, 100);
}

}  // namespace dynfilter::render
