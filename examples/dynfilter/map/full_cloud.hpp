// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/mapping/depth_cut.hpp>
#include <dynfilter/mapping/depth_points.hpp>
#include <dynfilter/mapping/map_frame.hpp>
#include <dynfilter/mapping/map_params.hpp>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "io/ply.hpp"
#include "map_output.hpp"

namespace dynfilter::command {

/// All points of the keyframes after the map's cut, neither merged into voxels nor carved.
/// For programs that downsample themselves, and as a reference for a map.
class FullCloud {
 public:
  /// Throws IoError if `file` cannot be created.
  FullCloud(const std::filesystem::path& file, const mapping::MappingParams& params)
      : file_(checked_target(file)), lock_(file_), params_(params), cut_(params.cut) {}

  void add(const MapInput& keyframe) {
    const auto start = std::chrono::steady_clock::now();
    const mapping::MapFrame frame = keyframe.view();
    rays_.set(frame.camera, frame.depth.size());
    // The cut also uses depths beyond the map's range.
    const mapping::DepthRange range{static_cast<float>(params_.min_depth_m), 65};
    if (!mapping::back_project_depth(frame.depth, frame.depth_unit_m, rays_, range, points_)) return;
    cut_.run(cv::Mat(frame.depth.size(), CV_32FC1, points_.z.data()), frame,
             static_cast<float>(params_.max_depth_m));
    chunks_.push_back({frame.id, frame.T_world_camera, {}, {}});
    Chunk& chunk = chunks_.back();
    for (int y = 0, i = 0; y < frame.depth.rows; ++y) {
      const std::uint8_t* usable = cut_.usable().ptr<std::uint8_t>(y);
      const cv::Vec3b* colour = frame.bgr.type() == CV_8UC3 ? frame.bgr.ptr<cv::Vec3b>(y) : nullptr;
      for (int x = 0; x < frame.depth.cols; ++x, ++i) {
        if (!usable[x]) continue;
        const auto k = static_cast<std::size_t>(i);
        chunk.points_m.emplace_back(points_.x[k], points_.y[k], points_.z[k]);
        chunk.colours.push_back(colour ? colour[x] : cv::Vec3b(128, 128, 128));
      }
    }
    spend(start);
  }

  void move(std::int64_t id, const Pose& T_world_camera) {
    for (Chunk& chunk : chunks_)
      if (chunk.id == id) chunk.T_world_camera = T_world_camera;
  }

  FullCloudSummary write() {
    const auto start = std::chrono::steady_clock::now();
    std::vector<cv::Point3f> points_m;
    std::vector<cv::Vec3b> colours;
    for (const Chunk& chunk : chunks_) {
      const Eigen::Matrix3f R = chunk.T_world_camera.R().cast<float>();
      const Eigen::Vector3f t = chunk.T_world_camera.t().cast<float>();
      for (const cv::Point3f& p : chunk.points_m) {
        const Eigen::Vector3f q = R * Eigen::Vector3f(p.x, p.y, p.z) + t;
        points_m.emplace_back(q.x(), q.y(), q.z());
      }
      colours.insert(colours.end(), chunk.colours.begin(), chunk.colours.end());
    }
    spend(start);
    io::write_ply(file_, points_m, colours);
    FullCloudSummary summary;
    summary.file = file_.string();
    summary.points = points_m.size();
    summary.bytes = points_m.size() * (sizeof(cv::Point3f) + sizeof(cv::Vec3b));
    if (!chunks_.empty()) summary.ms_per_keyframe = spent_ms_ / static_cast<double>(chunks_.size());
    return summary;
  }

 private:
  struct Chunk {
    std::int64_t id;
    Pose T_world_camera;
    std::vector<cv::Point3f> points_m;  ///< camera frame
    std::vector<cv::Vec3b> colours;
  };

  void spend(std::chrono::steady_clock::time_point since) {
    spent_ms_ += std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - since).count();
  }

  std::filesystem::path file_;
  io::OutputLock lock_;
  mapping::MappingParams params_;
  mapping::DepthCut cut_;
  mapping::PixelRays rays_;
  mapping::DepthPoints points_;
  std::vector<Chunk> chunks_;
  double spent_ms_ = 0;
};

}  // namespace dynfilter::command
