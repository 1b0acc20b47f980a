// SPDX-License-Identifier: MIT
#include "render/hall.hpp"

#include <opencv2/core.hpp>
#include <utility>

#include "render/room_materials.hpp"

namespace dynfilter::render {

Hall::Hall(MaterialSet& set, Random& random, int first_instance) {
  const RoomMaterials materials(set, random, RoomLook::Furnished);
  FurnitureBuilder build(materials, random, false, first_instance);
  shell(build);
  racks(build);
  workplaces(build);
  overhead(build);
  models = std::move(build.models);
  objects = std::move(build.objects);
  lighting.occluders = std::move(build.occluders);
  cargo(CargoMaterials(set, random), random);
  for (const float x : {-4.0F, 4.0F})
    for (const float y : {-6.5F, 0.0F, 6.5F})
      lighting.lamps.push_back({{x, y, 5.6F}, {6.2F, 6.4F, 6.5F}, 1.0F});
  for (Model& model : models) {
    model.finish();
    bake(model, lighting, random);
  }
}

inline void Hall::shell(FurnitureBuilder& b) {
  const RoomMaterials& m = b.materials();
  constexpr float kOver = 0.05F;  // beyond the walls, so that no crack is between them
  constexpr float kX = kHalfX + kOver, kY = kHalfY + kOver;
  add_rectangle(b.begin(), {{-kX, kY, 0}, {2 * kX, 0, 0}, {0, -2 * kY, 0}}, {m.floor, 2.6F}, 0.5F);
  add_rectangle(b.begin(), {{-kX, -kY, kHigh}, {2 * kX, 0, 0}, {0, 2 * kY, 0}}, {m.ceiling, 1.2F}, 0.8F);
  const Eigen::Vector3f down(0, 0, -kHigh);
  const Skin wall{m.wall, 2.8F};
  add_rectangle(b.begin(), {{-kHalfX, kHalfY, kHigh}, {2 * kHalfX, 0, 0}, down}, wall, 0.5F);
  add_rectangle(b.begin(), {{kHalfX, -kHalfY, kHigh}, {-2 * kHalfX, 0, 0}, down}, wall, 0.5F);
  add_rectangle(b.begin(), {{-kHalfX, -kHalfY, kHigh}, {0, 2 * kHalfY, 0}, down}, wall, 0.5F);
  add_rectangle(b.begin(), {{kHalfX, kHalfY, kHigh}, {0, -2 * kHalfY, 0}, down}, wall, 0.5F);
  for (const float x : {-5.0F, -1.7F, 1.7F, 5.0F}) {
    b.window({x, kHalfY - 0.02F, 4.2F}, 0, 2.2F, 1.8F);
    b.window({x, -kHalfY + 0.02F, 4.2F}, static_cast<float>(CV_PI), 2.2F, 1.8F);
  }
}

inline void Hall::racks(FurnitureBuilder& b) {
  const auto quarter = static_cast<float>(CV_PI) / 2;
  for (float y = -8.6F; y < 9; y += 2.15F) {
    b.bookshelf({-kHalfX + 0.2F, y, 0}, quarter, 1.9F, 2.4F);
    b.poster({-kHalfX + 0.02F, y, 3.4F}, quarter, 1.1F, 1.4F);
    b.bookshelf({kHalfX - 0.2F, y, 0}, -quarter, 1.9F, 2.3F);
    b.poster({kHalfX - 0.02F, y + 0.3F, 3.3F}, -quarter, 1.2F, 1.4F);
  }
  for (const float x : {-6.3F, -4.0F, -1.8F, 1.8F, 4.0F, 6.3F}) {
    b.bookshelf({x, kHalfY - 0.2F, 0}, 0, 1.8F, 2.3F);
    b.cabinet({x, -kHalfY + 0.26F, 0}, 2 * quarter);
    b.poster({x + 0.4F, -kHalfY + 0.02F, 2.3F}, 2 * quarter, 1.0F, 1.3F);
  }
  b.door({0, -kHalfY + 0.03F, 1.02F}, 2 * quarter);
  b.whiteboard({0, kHalfY - 0.02F, 1.5F}, 0, 1.6F, 1.1F);
}

inline void Hall::workplaces(FurnitureBuilder& b) {
  const auto half = static_cast<float>(CV_PI);
  for (const float y : {-5.5F, -1.0F, 3.5F}) {
    for (const float x : {-3.2F, 3.2F}) {
      b.furnished_desk({x, y, 0}, 0);
      b.furnished_desk({x, y + 0.95F, 0}, half);
      b.partition({x, y + 0.48F, 0}, 0, 1.9F);
      b.chair({x + 0.2F, y - 0.75F, 0}, half * 0.9F);
    }
    b.plant({0.3F, y + 2.2F, 0}, 1.3F);
  }
  const BoxSkin pillar = BoxSkin::all({b.materials().wall, 1.4F});
  for (const float x : {-6.4F, 6.4F})
    for (const float y : {-4.0F, 4.0F}) b.box({x, y, kHigh / 2}, 0, {0.4F, 0.4F, kHigh}, pillar);
}

inline void Hall::overhead(FurnitureBuilder& b) {
  const BoxSkin metal = BoxSkin::all({b.materials().metal, 0.8F});
  for (const float x : {-6.5F, -2.0F, 2.4F, 6.8F}) b.box({x, 0, 5.3F}, 0, {0.22F, 2 * kHalfY, 0.22F}, metal);
  for (float y = -8; y < 9; y += 4) b.box({0, y, 5.6F}, 0, {2 * kHalfX, 0.3F, 0.35F}, metal);
  for (const float x : {-4.0F, 4.0F})
    for (const float y : {-6.5F, 0.0F, 6.5F})
      b.box({x, y, 5.15F}, 0, {0.5F, 1.6F, 0.08F}, BoxSkin::all({b.materials().light_panel}));
}

inline void Hall::cargo(const CargoMaterials& cargo, Random& random) {
  const Eigen::Vector2f places[] = {{-6.2F, -7.5F}, {6.0F, -7.0F}, {-6.1F, 1.2F}, {6.1F, 1.6F},
                                    {-5.8F, 7.8F},  {5.9F, 7.6F},  {0.2F, 6.9F},  {-0.2F, -7.2F}};
  for (const Eigen::Vector2f& at : places) {
    Model cart = cargo_cart(cargo, 1.1F, static_cast<float>(random.uniform(1.2, 1.8)), random);
    const Eigen::Isometry3f frame = placed({at.x(), at.y(), 0}, static_cast<float>(random.uniform(0, 6)));
    for (Vertex& v : cart.vertices) {
      v.position_m = frame * v.position_m;
      v.normal = frame.linear() * v.normal;
    }
    models.push_back(std::move(cart));
  }
}

}  // namespace dynfilter::render
