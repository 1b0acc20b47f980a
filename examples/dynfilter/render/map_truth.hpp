// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/core/span.hpp>
#include <map>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <string>
#include <unordered_map>
#include <vector>

#include "render/mesh_distance.hpp"
#include "render/scenes.hpp"
#include "render/sequence_renderer.hpp"

namespace dynfilter::render {

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
  MapTruth(const std::string& scene, std::uint64_t seed);

  /// Seconds since the first frame for a timestamp.
  static double scene_time_s(double timestamp_s) {
    return timestamp_s - SequenceRenderer::first_timestamp_s();
  }

  /// Distance between the scene's camera and a given camera pose [m].
  double distance_from(double timestamp_s, const Pose& T_world_camera) const;

  bool on_mover(const Eigen::Vector3f& p, double timestamp_s);

  /// Adds the static surface visible in a frame: depth pixels with label 0, from the true pose.
  /// Uses every `step_px`-th pixel. `depth`: CV_16UC1 in units of `depth_unit_m`.
  void see(const cv::Mat& depth, double depth_unit_m, const cv::Mat& labels, const Camera& camera,
           const Pose& T_world_camera, int step_px = 4);

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

  static std::uint64_t cell_of(const Eigen::Vector3f& p);

  static double quantile(std::vector<float>& values, double share);

  const std::vector<Eigen::Isometry3f>& part_from_world(double timestamp_s);

  Scene scene_;
  MeshDistance room_;
  std::vector<Part> parts_;
  std::map<double, std::vector<Eigen::Isometry3f>> poses_;
  std::vector<Eigen::Isometry3d> world_from_part_;
  std::map<std::uint64_t, int> seen_;
};

}  // namespace dynfilter::render
