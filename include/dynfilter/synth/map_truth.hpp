// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/error.hpp>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/core/span.hpp>
#include <dynfilter/synth/mesh_distance.hpp>
#include <dynfilter/synth/scenes.hpp>
#include <dynfilter/synth/sequence.hpp>
#include <map>
#include <opencv2/core.hpp>
#include <string>
#include <tuple>
#include <unordered_map>
#include <utility>
#include <vector>

namespace dynfilter::synth {

/// Quality of a map of a rendered scene.
struct MapQuality {
  std::size_t points = 0;
  std::size_t ghosts = 0;  ///< points on a mover and on no static surface
  std::size_t astray = 0;  ///< points on no surface: noise, silhouettes, drift
  /// Distance from the true static surface over all points, up to `kFarM`.
  double error_median_m = NAN;
  double error_p95_m = NAN;
  std::size_t seen_cells = 0;  ///< cells of the static surface that the camera observed
  std::size_t covered_cells = 0;

  double ghost_share() const {
    return points > 0 ? static_cast<double>(ghosts) / static_cast<double>(points) : NAN;
  }
  double astray_share() const {
    return points > 0 ? static_cast<double>(astray) / static_cast<double>(points) : NAN;
  }
  double coverage() const {
    return seen_cells > 0 ? static_cast<double>(covered_cells) / static_cast<double>(seen_cells) : NAN;
  }
};

/// The exact surfaces of a scene, to evaluate maps.
/// Static surfaces are the room's triangles.
/// Mover surfaces are the triangles of each rigid part at a given time.
/// A point is on a surface if it is within `kOnM`.
class MapTruth {
 public:
  static constexpr float kOnM = 0.05F, kFarM = 1.0F, kCellM = 0.05F;

  /// Throws ConfigError for an unknown scene.
  MapTruth(const std::string& scene, std::uint64_t seed) : scene_(make_scene(scene, seed)) {
    for (const Model& model : scene_.room->models) room_.add(model);
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

  /// Seconds since the first frame for a timestamp.
  static double scene_time_s(double timestamp_s) {
    return timestamp_s - SequenceRenderer::first_timestamp_s();
  }

  /// Distance between the scene's camera and a given camera pose [m].
  double distance_from(double timestamp_s, const Pose& T_world_camera) const {
    const Eigen::Isometry3d T = scene_.camera->pose(scene_time_s(timestamp_s));
    return (T.translation() - T_world_camera.t()).norm();
  }

  MeshDistance::Nearest nearest_static(const Eigen::Vector3f& p, float within_m) const {
    return room_.nearest(p, within_m);
  }

  bool on_mover(const Eigen::Vector3f& p, double timestamp_s) {
    const std::vector<Eigen::Isometry3f>& T = part_from_world(timestamp_s);
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      const Eigen::Vector3f q = T[i] * p;
      if ((q - parts_[i].centre_m).norm() > parts_[i].radius_m + kOnM) continue;
      if (parts_[i].surface.nearest(q, kOnM).distance_m < kOnM) return true;
    }
    return false;
  }

  /// Adds the static surface visible in a frame: depth pixels with label 0, from the true pose.
  /// Uses every `step_px`-th pixel. `depth`: CV_16UC1 in units of `depth_unit_m`.
  void see(const cv::Mat& depth, double depth_unit_m, const cv::Mat& labels, const Camera& camera,
           const Pose& T_world_camera, int step_px = 4) {
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

  /// Evaluates points in the world of the scene.
  /// `sources_s(i)` returns the timestamps of the keyframes that contribute to point i.
  template <class Sources>
  MapQuality judge(Span<const cv::Point3f> points, const Sources& sources_s) {
    MapQuality quality;
    quality.points = points.size();
    std::vector<float> errors;
    std::unordered_map<std::uint64_t, int> covered;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Eigen::Vector3f p(points[i].x, points[i].y, points[i].z);
      const MeshDistance::Nearest hit = room_.nearest(p, kFarM);
      errors.push_back(std::min(hit.distance_m, kFarM));
      if (hit.distance_m <= kOnM) {
        covered[cell_of(hit.point)] = 1;
        continue;
      }
      bool ghost = false;
      for (const double stamp_s : sources_s(i)) ghost = ghost || on_mover(p, stamp_s);
      ++(ghost ? quality.ghosts : quality.astray);
    }
    for (const auto& [cell, times] : seen_) {
      if (times < kMinSeen) continue;
      ++quality.seen_cells;
      quality.covered_cells += covered.count(cell);
    }
    quality.error_median_m = quantile(errors, 0.5);
    quality.error_p95_m = quantile(errors, 0.95);
    return quality;
  }

 private:
  static constexpr int kMinSeen = 3;
  struct Part {
    MeshDistance surface;
    Eigen::Vector3f centre_m{0, 0, 0};
    float radius_m = 0;
  };

  static std::uint64_t cell_of(const Eigen::Vector3f& p) {
    constexpr float kOff = 0.0137F;  // walls are at round numbers
    std::uint64_t key = 0;
    for (int k = 0; k < 3; ++k)
      key = key << 21 | (static_cast<std::uint64_t>(
                             static_cast<std::int64_t>(std::floor((p[k] + kOff) / kCellM)) + (1 << 20)) &
                         0x1FFFFF);
    return key;
  }

  static double quantile(std::vector<float>& values, double share) {
    if (values.empty()) return NAN;
    const auto at =
        values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), at, values.end());
    return static_cast<double>(*at);
  }

  const std::vector<Eigen::Isometry3f>& part_from_world(double timestamp_s) {
    std::vector<Eigen::Isometry3f>& all = poses_[timestamp_s];
    if (!all.empty() || parts_.empty()) return all;
    for (const Mover& mover : scene_.movers) {
      mover.animation->pose(scene_time_s(timestamp_s), world_from_part_);
      for (std::size_t i = 0; i < mover.parts.size(); ++i)
        all.push_back(world_from_part_[i].inverse().cast<float>());
    }
    return all;
  }

  Scene scene_;
  MeshDistance room_;
  std::vector<Part> parts_;
  std::map<double, std::vector<Eigen::Isometry3f>> poses_;
  std::vector<Eigen::Isometry3d> world_from_part_;
  std::map<std::uint64_t, int> seen_;
};

}  // namespace dynfilter::synth
