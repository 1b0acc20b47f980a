// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <dynfilter/core/camera.hpp>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "render/mesh.hpp"
#include "render/rasteriser.hpp"
#include "render/scenes.hpp"

namespace dynfilter::render {

/// Poses of the drawn items in the world. Item 0 is the room, then all parts of all movers.
void item_poses(const Scene& scene, double time_s, std::vector<Eigen::Isometry3d>& out);

/// Draws a scene at one instant, from its camera or another pose.
class SceneDrawer {
 public:
  explicit SceneDrawer(const Camera& camera) : rasteriser_(camera) {}

  void draw(const Scene& scene, double time_s, const Eigen::Isometry3d& T_world_camera, GeometryImage& out);

  /// Draws only colour and only some rows, which is faster.
  /// The other rows of `colour` remain unchanged.
  void draw_colour(const Scene& scene, double time_s, const Eigen::Isometry3d& T_world_camera, RowRange rows,
                   cv::Mat& colour);

 private:
  void draw_models(const Scene& scene, double time_s, const Eigen::Isometry3d& T_world_camera);

  void shade(const Scene& scene, const Model& model, const Eigen::Isometry3f& T_world_part);

  Rasteriser rasteriser_;
  std::vector<Eigen::Isometry3d> poses_;
  std::vector<Eigen::Vector3f> shades_;
};

}  // namespace dynfilter::render
