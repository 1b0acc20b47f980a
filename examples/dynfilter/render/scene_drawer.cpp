// SPDX-License-Identifier: MIT
#include "render/scene_drawer.hpp"

#include <algorithm>
#include <cstddef>
#include <opencv2/core.hpp>

namespace dynfilter::render {

void item_poses(const Scene& scene, double time_s, std::vector<Eigen::Isometry3d>& out) {
  std::vector<Eigen::Isometry3d> parts;
  out.assign(1, Eigen::Isometry3d::Identity());
  for (const Mover& mover : scene.movers) {
    mover.animation->pose(time_s, parts);
    out.insert(out.end(), parts.begin(), parts.begin() + static_cast<std::ptrdiff_t>(mover.parts.size()));
  }
}

void SceneDrawer::draw(const Scene& scene, double time_s, const Eigen::Isometry3d& T_world_camera,
                       GeometryImage& out) {
  rasteriser_.begin();
  draw_models(scene, time_s, T_world_camera);
  rasteriser_.resolve(scene.materials, out);
}

void SceneDrawer::draw_colour(const Scene& scene, double time_s, const Eigen::Isometry3d& T_world_camera,
                              RowRange rows, cv::Mat& colour) {
  rasteriser_.begin(rows);
  draw_models(scene, time_s, T_world_camera);
  rasteriser_.resolve_colour(scene.materials, colour);
}

inline void SceneDrawer::draw_models(const Scene& scene, double time_s,
                                     const Eigen::Isometry3d& T_world_camera) {
  const Eigen::Isometry3f T_camera_world = T_world_camera.inverse().cast<float>();
  item_poses(scene, time_s, poses_);
  for (const Model& model : scene.surroundings->models) rasteriser_.draw(model, T_camera_world, 0);
  int item = 0;
  for (const Mover& mover : scene.movers) {
    for (const MoverPart& part : mover.parts) {
      const Eigen::Isometry3f T_world_part = poses_[static_cast<std::size_t>(++item)].cast<float>();
      shade(scene, part.model, T_world_part);
      rasteriser_.draw(part.model, T_camera_world * T_world_part, item, &shades_);
    }
  }
}

inline void SceneDrawer::shade(const Scene& scene, const Model& model,
                               const Eigen::Isometry3f& T_world_part) {
  shades_.resize(model.vertices.size());
  for (std::size_t i = 0; i < shades_.size(); ++i) {
    const Eigen::Vector3f p = T_world_part * model.vertices[i].position_m;
    const float open = std::min(1.0F, 0.62F + 0.28F * p.z());
    shades_[i] =
        scene.surroundings->lighting.shade(p, T_world_part.linear() * model.vertices[i].normal, open);
  }
}

}  // namespace dynfilter::render
