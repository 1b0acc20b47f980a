// SPDX-License-Identifier: MIT
#include "render/cart.hpp"

#include <algorithm>
#include <cstddef>
#include <opencv2/core.hpp>

#include "render/furniture.hpp"
#include "render/paint.hpp"
#include "render/room_materials.hpp"

namespace dynfilter::render {

CargoMaterials::CargoMaterials(MaterialSet& set, Random& r) {
  for (int i = 0; i < kBoxes; ++i) {
    cv::Mat box = picture::cardboard(r);
    if (i % 2) {
      picture::paint_shapes(box, r, 9);
      shade_by(box, fractal_noise(box.size(), {5, 5}, 5, 0.7, r), 0.4);
    }
    boxes.push_back(set.add(box));
  }
  metal = set.add(picture::plaster(r, bgr(120, 124, 134), 0.08), 0.08F);
  rubber = set.add(picture::plaster(r, bgr(36, 36, 38), 0.2), 0.2F);
}

Model cargo_box(const CargoMaterials& m, const Eigen::Vector3f& size, Random& r) {
  Model model;
  BoxSkin skin = BoxSkin::all({m.boxes[0]});
  for (Skin* side : {&skin.front, &skin.back, &skin.left, &skin.right, &skin.top})
    side->material = m.boxes[static_cast<std::size_t>(r.below(CargoMaterials::kBoxes))];
  add_box(model, Eigen::Isometry3f::Identity(), size, skin, 0.12F);
  model.finish();
  return model;
}

Model cargo_cart(const CargoMaterials& m, float wide_m, float high_m, Random& r) {
  Model model;
  const auto uniform = [&](double low, double high) { return static_cast<float>(r.uniform(low, high)); };
  const float deep = 0.5F * wide_m;
  add_box(model, placed({0, 0, 0.18F}, 0), {wide_m, deep, 0.05F}, BoxSkin::all({m.metal, 0.5F}), 0.12F);
  for (float x : {-0.42F, 0.42F}) {
    for (float y : {-0.36F, 0.36F})
      add_box(model, placed({x * wide_m, y * deep, 0.075F}, 0), {0.13F, 0.05F, 0.15F},
              BoxSkin::all({m.rubber, 0.3F}));
    add_box(model, placed({0.49F * wide_m, x * deep, 0.6F}, 0), {0.03F, 0.03F, 0.85F},
            BoxSkin::all({m.metal, 0.5F}), 0.2F);
  }
  add_box(model, placed({0.49F * wide_m, 0, 1.0F}, 0), {0.03F, 0.85F * deep, 0.03F},
          BoxSkin::all({m.metal, 0.5F}));
  float z = 0.205F;
  while (z < high_m - 0.1F) {
    const float high = std::min(uniform(0.26, 0.4), high_m - z);
    const int count = 2;
    for (int i = 0; i < count; ++i) {
      const float width = 0.44F * wide_m * uniform(0.86, 1.0),
                  x = (static_cast<float>(i) - 0.5F) * 0.46F * wide_m;
      BoxSkin skin = BoxSkin::all({m.boxes[0]});
      for (Skin* side : {&skin.front, &skin.back, &skin.left, &skin.right, &skin.top})
        side->material = m.boxes[static_cast<std::size_t>(r.below(CargoMaterials::kBoxes))];
      const Eigen::Vector3f size{width, deep * uniform(0.8, 0.96),
                                 high * (i == 0 ? 1.0F : uniform(0.85, 1.0))};
      const float yaw_rad = uniform(-0.1, 0.1);
      add_box(model, placed({x, uniform(-0.02, 0.02), z + high / 2}, yaw_rad), size, skin, 0.15F);
    }
    z += high;
  }
  model.finish();
  return model;
}

}  // namespace dynfilter::render
