// SPDX-License-Identifier: MIT
#include <cmath>
#include <cstdint>
#include <dynfilter/core/cpu.hpp>
#include <dynfilter/mapping/depth_points.hpp>
#include <dynfilter/mapping/point_block.hpp>
#include <dynfilter/mapping/voxel_grid.hpp>
#include <dynfilter/mapping/voxel_key.hpp>
#include <limits>
#include <memory>
#include <random>
#include <vector>

#include "doctest/doctest.h"

namespace dynfilter::mapping {
using dynfilter::detail::call_widest;
namespace {

constexpr float kLeafM = 0.02F;
const detail::GridScale kScale{4096 / kLeafM, 12, 20};

std::vector<cv::Point3f> points_near_and_far(unsigned seed, int n) {
  std::mt19937 source(seed);
  std::uniform_real_distribution<float> near(-5, 5);
  const float limit = static_cast<float>(VoxelKey::kOffset) * kLeafM;
  const float odd[] = {0,
                       -0.0F,
                       kLeafM,
                       -kLeafM,
                       limit,
                       -limit,
                       1e30F,
                       -std::numeric_limits<float>::infinity(),
                       std::numeric_limits<float>::quiet_NaN(),
                       1e-30F,
                       -1e-30F};
  std::vector<cv::Point3f> points;
  for (int i = 0; i < n; ++i) {
    points.emplace_back(near(source), near(source), near(source));
    if (source() % 4 == 0) (&points.back().x)[source() % 3] = odd[source() % std::size(odd)];
  }
  return points;
}

void fill(const std::vector<cv::Point3f>& points, std::mt19937& source, detail::PointBlock& block) {
  detail::take_points(points.data(), static_cast<int>(points.size()), block);
  for (std::size_t i = 0; i < points.size(); ++i) {
    block.label[i] = static_cast<std::uint8_t>(source() % 3);
    block.usable[i] = source() % 8 != 0 ? 1 : 0;
  }
}

bool within(double units) {
  const double limit = std::ldexp(1.0, 17 + 12);
  return units >= -limit && units < limit;
}

}  // namespace

TEST_CASE("the cell, remainder, key and place of a point are the floor of its coordinates, one by one") {
  std::mt19937 source(3);
  for (unsigned seed = 0; seed < 20; ++seed) {
    const std::vector<cv::Point3f> points = points_near_and_far(seed, 1 + static_cast<int>(source() % 256));
    detail::PointBlock block{};
    auto keyed = std::make_unique<detail::KeyedBlock>();
    fill(points, source, block);
    call_widest([&](auto lanes) DYNFILTER_AS_CALLER {
      detail::split_points<dynfilter::detail::Lanes<lanes()>>(block, kScale, *keyed);
    });
    for (std::size_t i = 0; i < points.size(); ++i) {
      // The product is a float's: what is checked is the division into cell and remainder.
      const double units[] = {static_cast<double>(points[i].x * kScale.per_unit),
                              static_cast<double>(points[i].y * kScale.per_unit),
                              static_cast<double>(points[i].z * kScale.per_unit)};
      const bool ok = block.usable[i] != 0 && within(units[0]) && within(units[1]) && within(units[2]);
      REQUIRE(keyed->ok[i] == (ok ? 1 : 0));
      if (!ok) continue;
      std::int32_t cells[3];
      for (std::size_t a = 0; a < 3; ++a) {
        cells[a] = static_cast<std::int32_t>(std::floor(units[a] / 4096));
        CHECK(keyed->cell[a][i] == cells[a]);
        CHECK(keyed->rest[a][i] == std::floor(units[a]) - cells[a] * 4096.0);
      }
      CHECK(keyed->key[i] == VoxelKey::pack(cells[0], cells[1], cells[2], block.label[i]));
      CHECK(keyed->place[i] == VoxelKey::place(keyed->key[i], kScale.table_bits));
      std::uint16_t summand[4];
      std::memcpy(summand, &keyed->summand[i], sizeof summand);
      for (std::size_t a = 0; a < 3; ++a) CHECK(summand[a] == keyed->rest[a][i]);
      CHECK(summand[3] == 1);
    }
  }
}

TEST_CASE("four lanes and eight split points into the same numbers") {
  std::mt19937 source(4);
  for (unsigned seed = 0; seed < 50; ++seed) {
    const std::vector<cv::Point3f> points = points_near_and_far(seed, 256);
    detail::PointBlock block{};
    auto narrow = std::make_unique<detail::KeyedBlock>(), wide = std::make_unique<detail::KeyedBlock>();
    fill(points, source, block);
    detail::split_points<dynfilter::detail::Lanes<4>>(block, kScale, *narrow);
    call_widest([&](auto lanes) DYNFILTER_AS_CALLER {
      detail::split_points<dynfilter::detail::Lanes<lanes()>>(block, kScale, *wide);
    });
    for (std::size_t i = 0; i < points.size(); ++i) {
      REQUIRE(narrow->key[i] == wide->key[i]);
      REQUIRE(narrow->place[i] == wide->place[i]);
      REQUIRE(narrow->ok[i] == wide->ok[i]);
      REQUIRE(narrow->summand[i] == wide->summand[i]);
      for (std::size_t a = 0; a < 3; ++a) REQUIRE(narrow->rest[a][i] == wide->rest[a][i]);
    }
  }
}

TEST_CASE("a centroid is the cell's corner and the mean remainder, to the last bit in both forms") {
  std::mt19937 source(5);
  const detail::CentroidScale scale{0.02 / 4096, 4096};
  for (int round = 0; round < 5000; ++round) {
    const auto count = static_cast<std::uint32_t>(1 + source() % (round % 2 == 0 ? 8 : 900000));
    const auto cell = [&] { return static_cast<std::int32_t>(source() % 262144) - 131072; };
    const std::int32_t cells[] = {cell(), cell(), cell()};
    detail::FourSums sums;
    for (int a = 0; a < 3; ++a) sums.v[a] = static_cast<std::uint32_t>(source() % (count * 4095ULL + 1));
    sums.v[3] = count;
    const std::uint64_t key = VoxelKey::pack(cells[0], cells[1], cells[2], static_cast<std::uint8_t>(round));
    VoxelPoint plain{}, wide{};
    detail::write_centroid(sums, key, scale, plain);
    call_widest([&](auto) DYNFILTER_AS_CALLER { detail::write_centroid(sums, key, scale, wide); });
    REQUIRE(plain == wide);
    const float found[] = {plain.x, plain.y, plain.z};
    for (int a = 0; a < 3; ++a) {
      const double units =
          cells[a] * 4096.0 + static_cast<double>(sums.v[a]) * (1.0 / static_cast<double>(count)) + 0.5;
      REQUIRE(found[a] == static_cast<float>(units * scale.unit_m));
    }
    REQUIRE(plain.count == count);
    REQUIRE(plain.label == static_cast<std::uint8_t>(round));
    REQUIRE((plain.b == 128 && plain.g == 128 && plain.r == 128));
  }
}

TEST_CASE("a key's place is the same by its halves, for tables of every size") {
  std::mt19937_64 source(6);
  for (int bits = 1; bits <= 32; ++bits)
    for (int i = 0; i < 100; ++i) {
      const std::uint64_t key = source() >> 2;
      const VoxelKey::Halves halves{static_cast<std::uint32_t>(key), static_cast<std::uint32_t>(key >> 32)};
      REQUIRE(VoxelKey::place(halves, bits) == VoxelKey::place(key, bits));
      REQUIRE(VoxelKey::place(key, bits) < std::uint64_t{1} << bits);
    }
}

TEST_CASE("depths become the same points with and without wide vectors") {
  std::mt19937 source(7);
  Camera camera;
  camera.fx_px = 517, camera.fy_px = 516, camera.cx_px = 30.3, camera.cy_px = 11.9;
  PixelRays rays;
  rays.set(camera, {61, 7});  // no multiple of eight
  for (const int type : {CV_16UC1, CV_32FC1}) {
    cv::Mat depth(7, 61, type);
    for (int y = 0; y < depth.rows; ++y)
      for (int x = 0; x < depth.cols; ++x)
        type == CV_16UC1 ? void(depth.at<std::uint16_t>(y, x) = static_cast<std::uint16_t>(source()))
                         : void(depth.at<float>(y, x) = static_cast<float>(source() % 70000));
    if (type == CV_32FC1) depth.at<float>(3, 17) = std::numeric_limits<float>::quiet_NaN();
    DepthPoints found;
    REQUIRE(back_project_depth(depth, 0.0002, rays, {0.1F, 10}, found));
    for (int y = 0; y < depth.rows; ++y) {
      float x_m[61], y_m[61], z_m[61];
      detail::read_points(depth, 0.0002F, {0.1F, 10}, rays, y, 0, depth.cols, x_m, y_m, z_m);
      for (int x = 0; x < depth.cols; ++x) {
        const auto i = static_cast<std::size_t>(y) * 61 + static_cast<std::size_t>(x);
        REQUIRE(found.x[i] == x_m[x]);
        REQUIRE(found.y[i] == y_m[x]);
        REQUIRE(found.z[i] == z_m[x]);
      }
    }
  }
}

}  // namespace dynfilter::mapping
