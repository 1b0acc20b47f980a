// SPDX-License-Identifier: MIT
#include "render/map_truth.hpp"

#include <opencv2/core.hpp>

#include "render/mesh.hpp"

namespace dynfilter::render {

MapTruth::MapTruth(const std::string& scene, std::uint64_t seed) : scene_(make_scene(scene, seed)) {
  for (const Model& model : scene_.surroundings->models) room_.add(model);
  room_.build();
  for (const Mover& mover : scene_.movers)
    for (const MoverPart& part : mover.parts) {
      parts_.emplace_back();
      parts_.back().surface.add(part.model);
      parts_.back().surface.build();
      parts_.back().centre_m = part.model.centre_m;
      parts_.back().radius_m = part.model.radius_m;
    }
}

double MapTruth::distance_from(double timestamp_s, const Pose& T_world_camera) const {
  const Eigen::Isometry3d T = scene_.camera->pose(scene_time_s(timestamp_s));
  return (T.translation() - T_world_camera.t()).norm();
}

bool MapTruth::on_mover(const Eigen::Vector3f& p, double timestamp_s) {
  const std::vector<Eigen::Isometry3f>& T = part_from_world(timestamp_s);
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    const Eigen::Vector3f q = T[i] * p;
    if ((q - parts_[i].centre_m).norm() > parts_[i].radius_m + kOnM) continue;
    if (parts_[i].surface.nearest(q, kOnM).distance_m < kOnM) return true;
  }
  return false;
}

void MapTruth::see(const cv::Mat& depth, double depth_unit_m, const cv::Mat& labels, const Camera& camera,
                   const Pose& T_world_camera, int step_px) {
  if (depth.type() != CV_16UC1 || labels.type() != CV_8UC1 || labels.size() != depth.size()) return;
  const Eigen::Isometry3f T = T_world_camera.isometry().cast<float>();
  for (int y = step_px / 2; y < depth.rows; y += step_px)
    for (int x = step_px / 2; x < depth.cols; x += step_px) {
      const double z = depth.at<std::uint16_t>(y, x) * depth_unit_m;
      if (z <= 0 || labels.at<std::uint8_t>(y, x) != 0) continue;
      const Eigen::Vector3d p((x - camera.cx_px) / camera.fx_px * z, (y - camera.cy_px) / camera.fy_px * z,
                              z);
      const MeshDistance::Nearest hit = room_.nearest(T * p.cast<float>(), kOnM);
      if (hit.distance_m < kOnM) ++seen_[cell_of(hit.point)];
    }
}

std::uint64_t MapTruth::cell_of(const Eigen::Vector3f& p) {
  constexpr float kOff = 0.0137F;  // walls are at round numbers
  std::uint64_t key = 0;
  for (int k = 0; k < 3; ++k)
    key = key << 21 | (static_cast<std::uint64_t>(
                           static_cast<std::int64_t>(std::floor((p[k] + kOff) / kCellM)) + (1 << 20)) &
                       0x1FFFFF);
  return key;
}

double MapTruth::quantile(std::vector<float>& values, double share) {
  if (values.empty()) return NAN;
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return static_cast<double>(*at);
}

inline const std::vector<Eigen::Isometry3f>& MapTruth::part_from_world(double timestamp_s) {
  std::vector<Eigen::Isometry3f>& all = poses_[timestamp_s];
  if (!all.empty() || parts_.empty()) return all;
  for (const Mover& mover : scene_.movers) {
    mover.animation->pose(scene_time_s(timestamp_s), world_from_part_);
    for (std::size_t i = 0; i < mover.parts.size(); ++i)
      all.push_back(world_from_part_[i].inverse().cast<float>());
  }
  return all;
}

}  // namespace dynfilter::render
