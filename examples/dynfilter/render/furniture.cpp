// SPDX-License-Identifier: MIT
#include "render/furniture.hpp"

#include <cmath>
#include <opencv2/core.hpp>

namespace dynfilter::render {

Eigen::Isometry3f placed(const Eigen::Vector3f& at, float yaw_rad) {
  Eigen::Isometry3f frame = Eigen::Isometry3f::Identity();
  frame.linear() = Eigen::AngleAxisf(yaw_rad, Eigen::Vector3f::UnitZ()).toRotationMatrix();
  frame.translation() = at;
  return frame;
}

Model& FurnitureBuilder::begin() {
  models.emplace_back();
  return models.back();
}

void FurnitureBuilder::box(const Eigen::Vector3f& centre, float yaw_rad, const Eigen::Vector3f& size,
                           const BoxSkin& skin) {
  begin();
  part(placed(centre, yaw_rad), size, skin);
}

void FurnitureBuilder::furnished_desk(const Eigen::Vector3f& at, float yaw_rad) {
  const Eigen::Isometry3f f = placed(at, yaw_rad);
  desk(f);
  const float mirror = random_.chance(0.5) ? 1.0F : -1.0F;
  const float monitor_yaw_rad = uniform(-0.12F, 0.12F);
  monitor(f, {mirror * 0.05F + uniform(-0.05F, 0.05F), 0.14F, 0.74F}, monitor_yaw_rad);
  if (plain_) return;
  keyboard(f, {mirror * 0.05F, -0.2F, 0.74F}, uniform(-0.12F, 0.12F));
  book_pile(f, {mirror * 0.5F, 0.12F, 0.74F}, 3 + random_.below(4));
  book_pile(f, {mirror * -0.5F, 0.02F, 0.74F}, 1 + random_.below(3));
  for (int i = 0; i < 3; ++i)
    sheet(f, {mirror * -0.42F + uniform(-0.2F, 0.2F), -0.2F + uniform(-0.08F, 0.08F), 0.742F});
  sheet(f, {mirror * 0.45F + uniform(-0.1F, 0.1F), -0.22F, 0.742F});
  mug(f, {mirror * 0.32F, -0.02F, 0.74F});
  mug(f, {mirror * -0.3F, 0.22F, 0.74F});
  part(sub(f, {mirror * 0.33F, -0.22F, 0.755F}, 0.2F), {0.06F, 0.1F, 0.03F},
       BoxSkin::all({m_.black, 0.3F}));  // mouse
  if (random_.chance(0.7))
    lamp(f, {mirror * -0.66F, 0.26F, 0.74F});
  else
    part(sub(f, {mirror * -0.62F, 0.24F, 0.86F}, 0.3F), {0.2F, 0.16F, 0.24F}, BoxSkin::all({m_.cardboard}));
}

void FurnitureBuilder::partition(const Eigen::Vector3f& at, float yaw_rad, float width) {
  const Eigen::Isometry3f f = placed(at, yaw_rad);
  begin();
  part(sub(f, {0, 0, 0.7F}), {width, 0.05F, 1.4F}, BoxSkin::all({m_.partition, 0.5F}), 0.14F);
  const BoxSkin rail = BoxSkin::all({m_.metal, 0.8F});
  part(sub(f, {0, 0, 1.42F}), {width, 0.06F, 0.04F}, rail);
  for (float x = -0.5F; x <= 0.51F; x += 0.333F)
    part(sub(f, {x * width, 0, 0.71F}), {0.04F, 0.07F, 1.42F}, rail);
  if (plain_) return;
  for (int i = 0; i < 7; ++i) {
    const float x = (static_cast<float>(i) - 3.0F) * width / 7.2F + uniform(-0.05F, 0.05F);
    const float w = uniform(0.24F, 0.4F);
    const int picture = pick(i % 3 ? m_.posters : m_.papers);
    hang(f * Eigen::Vector3f(x, -0.03F, 1.12F + uniform(-0.06F, 0.06F)), yaw_rad, w, w * 1.25F, picture);
  }
}

void FurnitureBuilder::chair(const Eigen::Vector3f& at, float yaw_rad) {
  const Eigen::Isometry3f f = placed(at, yaw_rad);
  begin();
  const BoxSkin cloth = BoxSkin::all({m_.chair_fabric, 0.35F}), frame = BoxSkin::all({m_.black, 0.5F});
  part(sub(f, {0, 0, 0.43F}), {0.46F, 0.46F, 0.06F}, cloth, 0.12F);
  part(sub(f, {0, 0.24F, 0.76F}), {0.44F, 0.05F, 0.42F}, cloth, 0.12F);
  part(sub(f, {0, 0.25F, 0.5F}), {0.06F, 0.03F, 0.2F}, frame);
  part(sub(f, {0, 0, 0.25F}), {0.05F, 0.05F, 0.32F}, frame);
  for (int i = 0; i < 5; ++i) {
    const float angle = static_cast<float>(2 * CV_PI / 5) * static_cast<float>(i);
    const Eigen::Vector3f foot(0.16F * std::cos(angle), 0.16F * std::sin(angle), 0.07F);
    part(sub(f, foot, angle), {0.32F, 0.05F, 0.04F}, frame);
    part(sub(f, foot * 1.9F - Eigen::Vector3f(0, 0, 0.1F), angle), {0.05F, 0.04F, 0.06F}, frame);
  }
}

void FurnitureBuilder::bookshelf(const Eigen::Vector3f& at, float yaw_rad, float width, float height) {
  const Eigen::Isometry3f f = placed(at, yaw_rad);
  begin();
  const BoxSkin board = BoxSkin::all({m_.wood_dark, 0.7F});
  const float depth = 0.3F;
  part(sub(f, {0, depth / 2 - 0.01F, height / 2}), {width, 0.02F, height}, board, 0.2F);
  for (float side : {-1.0F, 1.0F})
    part(sub(f, {side * width / 2, 0, height / 2}), {0.03F, depth, height}, board, 0.2F);
  const int shelves = static_cast<int>(height / 0.36F);
  for (int i = 0; i <= shelves; ++i) {
    const float z = 0.06F + (height - 0.08F) * static_cast<float>(i) / static_cast<float>(shelves);
    part(sub(f, {0, 0, z}), {width, depth, 0.025F}, board, 0.2F);
    if (i < shelves && !plain_) books_on_shelf(f, z + 0.013F, width - 0.06F, 0.27F);
  }
  for (int i = 0; i < 2 && !plain_; ++i) {
    const float box_yaw_rad = uniform(-0.3F, 0.3F);
    part(sub(f, {uniform(-0.3F, 0.3F) * width, 0, height + 0.14F}, box_yaw_rad), {0.32F, 0.24F, 0.24F},
         BoxSkin::all({m_.cardboard}));
  }
}

void FurnitureBuilder::cabinet(const Eigen::Vector3f& at, float yaw_rad) {
  const Eigen::Isometry3f f = placed(at, yaw_rad);
  begin();
  BoxSkin skin = BoxSkin::all({m_.white, 1.0F});
  skin.front = plain_ ? Skin{m_.white, 1.0F} : Skin{m_.drawers};
  skin.top = {m_.wood_light, 0.8F};
  part(sub(f, {0, 0, 0.55F}), {0.9F, 0.45F, 1.1F}, skin, 0.18F);
  if (plain_) return;
  book_pile(f, {-0.25F, 0, 1.1F}, 4);
  part(sub(f, {0.2F, 0.05F, 1.24F}, 0.25F), {0.36F, 0.28F, 0.28F}, BoxSkin::all({m_.cardboard}));
}

void FurnitureBuilder::plant(const Eigen::Vector3f& at, float size) {
  Model& model = begin();
  const Eigen::Isometry3f f = placed(at, 0);
  const float r = 0.17F;
  add_loft(model, f,
           {{0.36F, 0, 0, 0.01F, 0.01F},
            {0.34F, 0, 0, r * 0.9F, r * 0.9F},
            {0.38F, 0, 0, r, r},
            {0.36F, 0, 0, r * 1.02F, r * 1.02F},
            {0, 0, 0, r * 0.7F, r * 0.7F}},
           {m_.pot, 2, 1, 16});
  occlude(sub(f, {0, 0, 0.18F}), {0.26F, 0.26F, 0.36F});
  for (int i = 0; i < 46; ++i) leaf(model, f, size);
  model.finish();
}

void FurnitureBuilder::bin(const Eigen::Vector3f& at) {
  Model& model = begin();
  add_loft(model, placed(at, 0),
           {{0.3F, 0, 0, 0.01F, 0.01F},
            {0.3F, 0, 0, 0.14F, 0.14F},
            {0.32F, 0, 0, 0.15F, 0.15F},
            {0, 0, 0, 0.11F, 0.11F}},
           {m_.black, 4, 1, 16});
  occlude(placed(at + Eigen::Vector3f(0, 0, 0.15F), 0), {0.2F, 0.2F, 0.3F});
}

void FurnitureBuilder::poster(const Eigen::Vector3f& at, float yaw_rad, float width, float height) {
  if (plain_) return;
  begin();
  hang(at, yaw_rad, width, height, pick(m_.posters));
}

void FurnitureBuilder::whiteboard(const Eigen::Vector3f& at, float yaw_rad, float width, float height) {
  begin();
  hang(at, yaw_rad, width, height, plain_ ? m_.white : m_.whiteboard);
}

void FurnitureBuilder::window(const Eigen::Vector3f& at, float yaw_rad, float width, float height) {
  begin();
  hang(at, yaw_rad, width, height, plain_ ? m_.light_panel : m_.windows[windows_++ % 2]);
  const Eigen::Isometry3f f = placed(at, yaw_rad);
  part(sub(f, {0, -0.08F, -height / 2 - 0.02F}), {width + 0.1F, 0.18F, 0.04F}, BoxSkin::all({m_.white, 1}));
  part(sub(f, {0, -0.03F, -height / 2 - 0.42F}), {width * 0.8F, 0.08F, 0.5F},
       BoxSkin::all(plain_ ? Skin{m_.white, 1} : Skin{m_.radiator}), 0.2F);
}

void FurnitureBuilder::door(const Eigen::Vector3f& at, float yaw_rad) {
  begin();
  part(placed(at, yaw_rad), {0.95F, 0.05F, 2.04F}, BoxSkin::all({m_.door}), 0.3F);
}

inline int FurnitureBuilder::object(int class_id, const char* name) {
  objects.push_back({class_id, name});
  return first_instance_ + static_cast<int>(objects.size());
}

void FurnitureBuilder::part(const Eigen::Isometry3f& frame, const Eigen::Vector3f& size, const BoxSkin& skin,
                            float cell_m, int instance) {
  add_box(models.back(), frame, size, skin, cell_m, instance);
  if (size.norm() > 0.12F) occlude(frame, size);
}

inline void FurnitureBuilder::desk(const Eigen::Isometry3f& f) {
  begin();
  part(sub(f, {0, 0, 0.72F}), {1.6F, 0.8F, 0.04F}, BoxSkin::all({m_.wood_light, 0.9F}), 0.08F);
  const BoxSkin leg = BoxSkin::all({m_.metal, 0.6F});
  for (float x : {-0.74F, 0.74F}) {
    for (float y : {-0.34F, 0.34F}) part(sub(f, {x, y, 0.35F}), {0.05F, 0.05F, 0.7F}, leg, 0.2F);
  }
  part(sub(f, {0, 0.36F, 0.5F}), {1.44F, 0.02F, 0.36F}, BoxSkin::all({m_.wood_light, 0.9F}), 0.2F);
  BoxSkin drawers = BoxSkin::all({m_.white, 1.0F});
  if (!plain_) drawers.front = {m_.drawers};
  part(sub(f, {0.5F, 0.02F, 0.33F}), {0.4F, 0.6F, 0.6F}, drawers, 0.2F);
  if (!plain_)
    part(sub(f, {-0.45F, 0.1F, 0.22F}), {0.2F, 0.45F, 0.42F}, BoxSkin::all({m_.black, 0.6F}),
         0.2F);  // computer
}

inline void FurnitureBuilder::monitor(const Eigen::Isometry3f& f, const Eigen::Vector3f& at, float yaw_rad) {
  const Eigen::Isometry3f g = sub(f, at, yaw_rad);
  const int instance = object(62, "tv");
  BoxSkin skin = BoxSkin::all({m_.black, 0.5F});
  skin.front = {pick(m_.screens)};
  part(sub(g, {0, 0, 0.32F}), {0.56F, 0.04F, 0.34F}, skin, 0.3F, instance);
  part(sub(g, {0, 0.04F, 0.1F}), {0.06F, 0.04F, 0.2F}, BoxSkin::all({m_.black, 0.5F}), 0.3F, instance);
  part(sub(g, {0, 0.03F, 0.01F}), {0.24F, 0.18F, 0.02F}, BoxSkin::all({m_.black, 0.5F}), 0.3F, instance);
}

inline void FurnitureBuilder::keyboard(const Eigen::Isometry3f& f, const Eigen::Vector3f& at, float yaw_rad) {
  BoxSkin skin = BoxSkin::all({m_.black, 0.5F});
  skin.top = {m_.keyboard};
  part(sub(f, at + Eigen::Vector3f(0, 0, 0.012F), yaw_rad), {0.44F, 0.15F, 0.024F}, skin, 0.2F,
       object(66, "keyboard"));
}

inline void FurnitureBuilder::book_pile(const Eigen::Isometry3f& f, const Eigen::Vector3f& at, int count) {
  const int instance = object(73, "book");
  float z = at.z();
  for (int i = 0; i < count; ++i) {
    const float thick = uniform(0.018F, 0.045F);
    BoxSkin skin = BoxSkin::all({m_.pages});
    skin.top = {pick(m_.covers)};
    skin.front = back_of_book(true);
    const Eigen::Vector3f size{uniform(0.22F, 0.28F), uniform(0.16F, 0.2F), thick};
    const float yaw_rad = uniform(-0.35F, 0.35F);
    part(sub(f, {at.x() + uniform(-0.015F, 0.015F), at.y() + uniform(-0.015F, 0.015F), z + thick / 2},
             yaw_rad),
         size, skin, 0.2F, instance);
    z += thick;
  }
}

inline Skin FurnitureBuilder::back_of_book(bool lying) {
  const float column = static_cast<float>(random_.below(picture::kBooks)) / picture::kBooks;
  return {m_.book_backs, 0,
          cv::Rect2f(column, lying ? 0.2F : 0.0F, 1.0F / picture::kBooks, lying ? 0.1F : 1.0F)};
}

inline void FurnitureBuilder::books_on_shelf(const Eigen::Isometry3f& f, float z, float width,
                                             float most_high) {
  float x = -width / 2;
  while (x < width / 2 - 0.05F) {
    if (random_.chance(0.05)) {
      x += uniform(0.05F, 0.15F);
      continue;
    }
    const float thick = uniform(0.02F, 0.05F), high = most_high * uniform(0.68F, 1.0F),
                deep = uniform(0.16F, 0.22F);
    BoxSkin skin = BoxSkin::all({m_.pages});
    skin.back.material = skin.bottom.material = kNoSkin;
    skin.front = back_of_book(false);
    skin.left =
        skin.right = {skin.front.material, 0, cv::Rect2f(skin.front.window.x + 0.012F, 0.9F, 0.002F, 0.02F)};
    add_box(models.back(), sub(f, {x + thick / 2, 0.12F - deep / 2, z + high / 2}), {thick, deep, high},
            skin);
    x += thick + 0.001F;
  }
  occlude(sub(f, {0, 0.03F, z + 0.11F}), {width, 0.18F, 0.2F});
}

inline void FurnitureBuilder::sheet(const Eigen::Isometry3f& f, const Eigen::Vector3f& at) {
  BoxSkin skin = BoxSkin::all({m_.white, 1});
  skin.top = {pick(m_.papers)};
  const float yaw_rad = uniform(-0.5F, 0.5F);
  add_box(models.back(), sub(f, at + Eigen::Vector3f(0, 0, uniform(0, 0.002F)), yaw_rad),
          {0.21F, 0.297F, 0.002F}, skin);
}

inline void FurnitureBuilder::mug(const Eigen::Isometry3f& f, const Eigen::Vector3f& at) {
  const Eigen::Isometry3f g = sub(f, at);
  add_loft(models.back(), g,
           {{0.09F, 0, 0, 0.002F, 0.002F},
            {0.095F, 0, 0, 0.04F, 0.04F},
            {0.05F, 0, 0, 0.04F, 0.04F},
            {0, 0, 0, 0.036F, 0.036F}},
           {m_.mug, 1, 1, 14});
  occlude(sub(g, {0, 0, 0.05F}), {0.07F, 0.07F, 0.09F});
}

inline void FurnitureBuilder::lamp(const Eigen::Isometry3f& f, const Eigen::Vector3f& at) {
  const Eigen::Isometry3f g = sub(f, at);
  Model& model = models.back();
  add_loft(model, g, {{0.03F, 0, 0, 0.002F, 0.002F}, {0.025F, 0, 0, 0.07F, 0.07F}, {0, 0, 0, 0.08F, 0.08F}},
           {m_.black, 1, 1, 16});
  add_loft(model, g, {{0.36F, 0, 0, 0.01F, 0.01F}, {0, 0, 0, 0.01F, 0.01F}}, {m_.metal, 1, 1, 8});
  add_loft(
      model, g,
      {{0.46F, 0, -0.05F, 0.03F, 0.03F}, {0.34F, 0, -0.08F, 0.1F, 0.1F}, {0.345F, 0, -0.08F, 0.01F, 0.01F}},
      {m_.pot, 1, 1, 16});
}

inline void FurnitureBuilder::leaf(Model& model, const Eigen::Isometry3f& f, float size) {
  const float azimuth = uniform(0, static_cast<float>(2 * CV_PI)), high = uniform(0.45F, 1.0F) * size;
  const float reach = uniform(0.1F, 0.3F) * size;
  const Eigen::Vector3f out(std::cos(azimuth), std::sin(azimuth), 0), side(-out.y(), out.x(), 0);
  const Eigen::Vector3f stem = Eigen::Vector3f(0, 0, 0.3F + 0.6F * (high - 0.3F)) + 0.3F * reach * out;
  const Eigen::Vector3f tip = Eigen::Vector3f(0, 0, high) + reach * out;
  const float width = uniform(0.05F, 0.09F) * size;
  const Eigen::Vector3f along = (tip - stem) * 0.85F,
                        across = side * width + Eigen::Vector3f(0, 0, uniform(-0.03F, 0.03F));
  const Rectangle front{f * (stem - across / 2).eval(), f.linear() * across, f.linear() * along};
  add_rectangle(model, front, {m_.leaf}, 0.2F);
  add_rectangle(model, {front.corner + front.right, -front.right, front.down}, {m_.leaf}, 0.2F);
}

}  // namespace dynfilter::render
