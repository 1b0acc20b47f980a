// SPDX-License-Identifier: MIT
// The map's loops at every address that points and depths may have: depth images are often parts of larger
// ones.
#include <cstdint>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/random.hpp>
#include <dynfilter/mapping/depth_points.hpp>
#include <dynfilter/mapping/voxel_grid.hpp>
#include <opencv2/core.hpp>
#include <vector>

#include "doctest/doctest.h"

namespace misaligned_points_test {

using namespace dynfilter;
using namespace dynfilter::mapping;

namespace {

constexpr int kRegister = 32;  ///< bytes

}  // namespace

TEST_CASE("voxels of points at every address are those of a copy") {
  Random random(5);
  constexpr std::size_t kPoints = 600, kOffsets = kRegister / sizeof(float);
  std::vector<cv::Point3f> memory(kPoints + kOffsets);
  VoxelGrid grid(0.2);
  for (std::size_t offset = 0; offset < kOffsets; ++offset) {  // 12 bytes each: every multiple of 4 in turn
    std::vector<cv::Point3f> copy;
    for (std::size_t k = 0; k < kPoints; ++k) {
      memory[k + offset] = {static_cast<float>(random.uniform(-3, 3)),
                            static_cast<float>(random.uniform(-3, 3)),
                            static_cast<float>(random.uniform(-3, 3))};
      copy.push_back(memory[k + offset]);
    }
    std::vector<VoxelPoint> there, here;
    grid.run(Span<const cv::Point3f>(memory.data() + offset, kPoints), {}, there);
    grid.run(copy, {}, here);
    CHECK(here.size() > 100);
    CHECK((there == here));
  }
}

TEST_CASE("voxels of parts of depth images at every address are those of a copy") {
  Random random(6);
  const cv::Size size(70, 20);
  Camera camera;
  camera.fx_px = camera.fy_px = 60, camera.cx_px = 35, camera.cy_px = 10;
  PixelRays rays;
  rays.set(camera, size);
  VoxelGrid grid(0.1);
  for (const int type : {CV_16UC1, CV_32FC1}) {
    cv::Mat whole(size.height, size.width + kRegister, type);
    for (int y = 0; y < whole.rows; ++y)
      for (int x = 0; x < whole.cols; ++x) {
        const double depth_mm = random.uniform(300, 5000);
        if (type == CV_16UC1)
          whole.at<std::uint16_t>(y, x) = static_cast<std::uint16_t>(depth_mm);
        else
          whole.at<float>(y, x) = static_cast<float>(depth_mm);
      }
    for (int offset = 0; offset < kRegister / static_cast<int>(whole.elemSize()); ++offset) {
      DepthSource part, copy;
      part.depth = whole(cv::Rect({offset, 0}, size));
      copy.depth = part.depth.clone();
      part.unit_m = copy.unit_m = 1e-3;
      part.rays = copy.rays = &rays;
      std::vector<VoxelPoint> there, here;
      grid.run(part, there);
      grid.run(copy, here);
      CHECK(here.size() > 100);
      CHECK((there == here));
    }
  }
}

}  // namespace misaligned_points_test
