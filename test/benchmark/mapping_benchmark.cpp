// SPDX-License-Identifier: MIT
// The voxel grid against PCL's VoxelGrid, and back-projection against OpenCV's rgbd::depthTo3d.
// A reference is used if it is installed.
// The input is 307,200 points of a room from a noisy depth camera.
// `ratio` is the quotient of the medians in the same run.
#include <benchmark/benchmark.h>

#include <cmath>
#include <dynfilter/geometry/depth_noise.hpp>
#include <dynfilter/mapping/depth_points.hpp>
#include <dynfilter/mapping/voxel_grid.hpp>
#include <random>
#include <vector>

#ifdef DYNFILTER_HAS_PCL
#include <pcl/filters/voxel_grid.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>
#endif
#ifdef DYNFILTER_HAS_RGBD
#include <opencv2/rgbd/depth.hpp>
#endif

#include "benchmark/ratio.hpp"

using namespace dynfilter;
using namespace dynfilter::mapping;

namespace {

constexpr std::size_t kSets = 8;

Camera camera_640() {
  Camera camera;
  camera.fx_px = camera.fy_px = 525, camera.cx_px = 319.5, camera.cy_px = 239.5;
  return camera;
}

/// A floor, a slanted wall and a box, at TUM's scale.
cv::Mat room(unsigned seed) {
  std::mt19937 source(seed);
  cv::Mat depth(480, 640, CV_16UC1);
  for (int y = 0; y < depth.rows; ++y)
    for (int x = 0; x < depth.cols; ++x) {
      double z = 3.5 + 0.001 * (x - 320) + 0.1 * seed;
      if (y > 260) z = std::min(z, 1.2 * 525 / (y - 239.5));
      if (std::abs(x - 200 - 20 * static_cast<int>(seed)) < 80 && y > 150) z = std::min(z, 1.6);
      double bell = -6;
      for (int k = 0; k < 12; ++k) bell += static_cast<double>(source()) / 4294967296.0;
      z += DepthNoise().sigma_m(z) * bell;
      depth.at<std::uint16_t>(y, x) = static_cast<std::uint16_t>(z * 5000);
    }
  return depth;
}

struct Sets {
  std::vector<cv::Mat> depths;
  std::vector<std::vector<cv::Point3f>> points;
  PixelRays rays;

  Sets() {
    rays.set(camera_640(), {640, 480});
    DepthPoints p;
    for (unsigned s = 0; s < kSets; ++s) {
      depths.push_back(room(s));
      back_project_depth(depths.back(), 1 / 5000.0, rays, DepthRange(), p);
      points.emplace_back();
      for (std::size_t i = 0; i < p.z.size(); ++i) points.back().emplace_back(p.x[i], p.y[i], p.z[i]);
    }
  }
};

#ifdef DYNFILTER_HAS_PCL
void voxel_grid_against(benchmark::State& state, bool fused) {
  const Sets sets;
  const auto leaf = static_cast<float>(state.range(0)) / 100;
  std::vector<pcl::PointCloud<pcl::PointXYZ>::Ptr> clouds;
  for (const auto& points : sets.points) {
    clouds.emplace_back(new pcl::PointCloud<pcl::PointXYZ>);
    for (const cv::Point3f& p : points) clouds.back()->push_back({p.x, p.y, p.z});
  }
  VoxelGrid grid(static_cast<double>(leaf));
  std::vector<VoxelPoint> ours;
  pcl::PointCloud<pcl::PointXYZ> theirs;
  DepthSource from;
  from.unit_m = 1 / 5000.0, from.rays = &sets.rays;
  bench::compare(
      state, kSets,
      [&](std::size_t s) {
        from.depth = sets.depths[s];
        fused ? grid.run(from, ours) : grid.run(sets.points[s], {}, ours);
      },
      [&](std::size_t s) {
        pcl::VoxelGrid<pcl::PointXYZ> pcl_grid;
        pcl_grid.setInputCloud(clouds[s]);
        pcl_grid.setLeafSize(leaf, leaf, leaf);
        pcl_grid.filter(theirs);
      });
  state.counters["voxels"] = static_cast<double>(ours.size());
  state.counters["anchor_voxels"] = static_cast<double>(theirs.size());
}
void voxel_grid(benchmark::State& state) {
  voxel_grid_against(state, false);
}
void voxel_grid_from_depth(benchmark::State& state) {
  voxel_grid_against(state, true);
}
BENCHMARK(voxel_grid)->Arg(1)->Arg(2)->Arg(5)->UseManualTime()->Iterations(48)->Unit(benchmark::kMillisecond);
BENCHMARK(voxel_grid_from_depth)
    ->Arg(1)
    ->Arg(2)
    ->Arg(5)
    ->UseManualTime()
    ->Iterations(48)
    ->Unit(benchmark::kMillisecond);
#endif

#ifdef DYNFILTER_HAS_RGBD
void back_projection(benchmark::State& state) {
  const Sets sets;
  const cv::Mat K = (cv::Mat_<float>(3, 3) << 525, 0, 319.5, 0, 525, 239.5, 0, 0, 1);
  DepthPoints ours;
  cv::Mat theirs;
  bench::compare(
      state, kSets,
      [&](std::size_t s) { back_project_depth(sets.depths[s], 1 / 5000.0, sets.rays, DepthRange(), ours); },
      [&](std::size_t s) { cv::rgbd::depthTo3d(sets.depths[s], K, theirs); });
}
BENCHMARK(back_projection)->UseManualTime()->Iterations(160)->Unit(benchmark::kMillisecond);
#endif

/// Cost of a leaf size, without a reference.
void voxel_grid_alone(benchmark::State& state) {
  const Sets sets;
  VoxelGrid grid(static_cast<double>(state.range(0)) / 100);
  std::vector<VoxelPoint> found;
  std::size_t s = 0;
  for (auto _ : state) grid.run(sets.points[s++ % kSets], {}, found);
}
BENCHMARK(voxel_grid_alone)->Arg(1)->Arg(2)->Arg(5)->Unit(benchmark::kMillisecond);

}  // namespace

BENCHMARK_MAIN();
