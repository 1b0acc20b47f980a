// SPDX-License-Identifier: MIT
#include "render/room.hpp"

#include <utility>

#include "render/room_materials.hpp"

namespace dynfilter::render {

Room::Room(MaterialSet& set, Random& random, RoomLook look, const std::vector<Eigen::Vector3f>& chairs,
           int first_instance) {
  const RoomMaterials materials(set, random, look);
  FurnitureBuilder build(materials, random, look != RoomLook::Furnished, first_instance);
  shell(build);
  desks(build);
  along_walls(build);
  for (const Eigen::Vector3f& c : chairs) build.chair({c.x(), c.y(), 0}, c.z());
  models = std::move(build.models);
  objects = std::move(build.objects);
  lighting.occluders = std::move(build.occluders);
  lighting.lamps = {{{-1.6F, -1.6F, 2.7F}, {1.55F, 1.6F, 1.62F}},
                    {{1.6F, -1.6F, 2.7F}, {1.55F, 1.6F, 1.62F}},
                    {{-1.6F, 1.6F, 2.7F}, {1.4F, 1.45F, 1.48F}},
                    {{1.6F, 1.6F, 2.7F}, {1.4F, 1.45F, 1.48F}},
                    {{-3.6F, 0.6F, 1.7F}, {1.35F, 1.15F, 1.0F}}};
  for (Model& model : models) {
    model.finish();
    bake(model, lighting, random);
  }
}

inline void Room::shell(FurnitureBuilder& b) {
  const RoomMaterials& m = b.materials();
  Model& floor = b.begin();
  add_rectangle(floor, {{-kHalfX, kHalfY, 0}, {2 * kHalfX, 0, 0}, {0, -2 * kHalfY, 0}}, {m.floor, 2.0F},
                0.16F);
  Model& ceiling = b.begin();
  add_rectangle(ceiling, {{-kHalfX, -kHalfY, kHigh}, {2 * kHalfX, 0, 0}, {0, 2 * kHalfY, 0}},
                {m.ceiling, 0.6F}, 0.4F);
  const Eigen::Vector3f down(0, 0, -kHigh);
  const Skin wall{m.wall, 2.2F};
  Model& walls = b.begin();
  add_rectangle(walls, {{-kHalfX, kHalfY, kHigh}, {2 * kHalfX, 0, 0}, down}, wall, 0.25F);
  add_rectangle(walls, {{kHalfX, -kHalfY, kHigh}, {-2 * kHalfX, 0, 0}, down}, wall, 0.25F);
  add_rectangle(walls, {{-kHalfX, -kHalfY, kHigh}, {0, 2 * kHalfY, 0}, down}, wall, 0.25F);
  add_rectangle(walls, {{kHalfX, kHalfY, kHigh}, {0, -2 * kHalfY, 0}, down}, wall, 0.25F);
  for (float x : {-1.6F, 1.6F}) {
    for (float y : {-1.6F, 1.6F})
      b.box({x, y, kHigh - 0.02F}, 0, {0.6F, 1.2F, 0.04F}, BoxSkin::all({m.light_panel}));
  }
  skirting(b);
}

inline void Room::skirting(FurnitureBuilder& b) {
  const BoxSkin skin = BoxSkin::all({b.materials().wood_dark, 0.8F});
  b.box({0, kHalfY - 0.01F, 0.05F}, 0, {2 * kHalfX, 0.02F, 0.1F}, skin);
  b.box({0, -kHalfY + 0.01F, 0.05F}, 0, {2 * kHalfX, 0.02F, 0.1F}, skin);
  b.box({-kHalfX + 0.01F, 0, 0.05F}, 0, {0.02F, 2 * kHalfY, 0.1F}, skin);
  b.box({kHalfX - 0.01F, 0, 0.05F}, 0, {0.02F, 2 * kHalfY, 0.1F}, skin);
}

inline void Room::desks(FurnitureBuilder& b) {
  b.furnished_desk({-0.82F, 0.75F, 0}, 0);
  b.furnished_desk({0.82F, 0.75F, 0}, 0);
  b.partition({0, 1.75F, 0}, 0, 4.2F);
  b.chair({-0.75F, 1.42F, 0}, static_cast<float>(CV_PI) * 0.95F);
  b.chair({0.95F, 1.40F, 0}, static_cast<float>(CV_PI) * 1.08F);
  b.furnished_desk({-2.75F, -0.3F, 0}, static_cast<float>(CV_PI) / 2);
  b.chair({-2.05F, -0.3F, 0}, static_cast<float>(-CV_PI) * 0.45F);
  b.plant({1.95F, 0.75F, 0}, 1.0F);
  b.bin({-1.8F, 0.45F, 0});
}

inline void Room::along_walls(FurnitureBuilder& b) {
  const float quarter = static_cast<float>(CV_PI) / 2;
  b.bookshelf({-2.75F, kHalfY - 0.17F, 0}, 0, 1.1F, 2.1F);
  b.window({-0.9F, kHalfY - 0.02F, 1.65F}, 0, 1.5F, 1.3F);
  b.window({0.9F, kHalfY - 0.02F, 1.65F}, 0, 1.5F, 1.3F);
  b.bookshelf({2.75F, kHalfY - 0.17F, 0}, 0, 1.3F, 2.0F);
  b.bookshelf({kHalfX - 0.17F, 1.9F, 0}, -quarter, 1.2F, 2.1F);
  b.cabinet({2.9F, 0.35F, 0}, -quarter);
  b.furnished_desk({kHalfX - 0.42F, -1.3F, 0}, -quarter);
  b.chair({2.75F, -1.3F, 0}, quarter * 1.15F);
  b.window({-kHalfX + 0.02F, 0.6F, 1.6F}, quarter, 1.5F, 1.3F);
  b.cabinet({-kHalfX + 0.26F, 2.1F, 0}, quarter);
  b.whiteboard({-kHalfX + 0.02F, -1.9F, 1.5F}, quarter, 1.8F, 1.0F);
  b.poster({kHalfX - 0.02F, 0.35F, 1.75F}, -quarter, 0.7F, 1.0F);
  b.poster({kHalfX - 0.02F, -0.9F, 1.7F}, -quarter, 0.7F, 1.0F);
  b.poster({kHalfX - 0.02F, -1.9F, 1.6F}, -quarter, 0.6F, 0.85F);
  b.poster({-kHalfX + 0.02F, -0.5F, 1.6F}, quarter, 0.6F, 0.9F);
  b.poster({-3.65F, kHalfY - 0.02F, 1.6F}, 0, 0.5F, 0.75F);
  b.poster({-1.93F, kHalfY - 0.02F, 1.7F}, 0, 0.5F, 0.75F);
  b.poster({1.87F, kHalfY - 0.02F, 1.75F}, 0, 0.4F, 0.6F);
  b.poster({3.7F, kHalfY - 0.02F, 1.6F}, 0, 0.5F, 0.75F);
  b.plant({3.4F, 3.1F, 0}, 1.35F);
  b.plant({-3.5F, -3.3F, 0}, 1.2F);
  south_wall(b);
}

inline void Room::south_wall(FurnitureBuilder& b) {
  const float half = static_cast<float>(CV_PI);
  b.door({-1.8F, -kHalfY + 0.03F, 1.02F}, half);
  b.bookshelf({0.2F, -kHalfY + 0.17F, 0}, half, 1.5F, 1.9F);
  b.cabinet({2.0F, -kHalfY + 0.26F, 0}, half);
  b.poster({2.0F, -kHalfY + 0.02F, 1.8F}, half, 0.6F, 0.9F);
  b.poster({3.1F, -kHalfY + 0.02F, 1.6F}, half, 0.7F, 1.0F);
  b.poster({-3.0F, -kHalfY + 0.02F, 1.6F}, half, 0.7F, 1.0F);
  b.poster({-0.9F, -kHalfY + 0.02F, 1.7F}, half, 0.5F, 0.7F);
}

}  // namespace dynfilter::render
