// SPDX-License-Identifier: MIT
#include <array>
#include <cmath>
#include <cstdint>
#include <dynfilter/mapping/carving.hpp>
#include <dynfilter/mapping/map_cloud.hpp>
#include <dynfilter/mapping/mapping_thread.hpp>
#include <dynfilter/mapping/outliers.hpp>
#include <dynfilter/mapping/static_map.hpp>
#include <limits>
#include <map>
#include <random>
#include <vector>
#include "io/cloud_picture.hpp"

#include "doctest/doctest.h"
#include "support/parameter_tables.hpp"

namespace static_map_test {

using namespace dynfilter;
using namespace dynfilter::mapping;

namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

Camera camera_160() {
  Camera camera;
  camera.fx_px = camera.fy_px = 130, camera.cx_px = 79.5, camera.cy_px = 59.5;
  return camera;
}

/// A wall at 3 m in front of the world's origin, viewed from (x, 0, 0).
/// With `person`, a box of 0.8 m at 1.5 m.
MapFrame wall(std::int64_t id, double x_m, bool person) {
  MapFrame frame;
  frame.id = id;
  frame.camera = camera_160();
  frame.T_world_camera.translation_m = {x_m, 0, 0};
  frame.depth = cv::Mat(120, 160, CV_32FC1, cv::Scalar(3));
  if (person) {
    const int left = cvRound(130 * (-0.4 - x_m) / 1.5 + 79.5),
              right = cvRound(130 * (0.4 - x_m) / 1.5 + 79.5);
    frame.depth(cv::Rect(left, 20, right - left, 90) & cv::Rect(0, 0, 160, 120)).setTo(1.5);
  }
  return frame;
}

std::map<std::uint64_t, std::pair<Voxel, VoxelVotes>> content(const VoxelMap& map) {
  std::map<std::uint64_t, std::pair<Voxel, VoxelVotes>> voxels;
  for (std::size_t i = 0; i < map.size(); ++i) voxels[map.keys()[i]] = {map.voxels()[i], map.votes()[i]};
  return voxels;
}

std::size_t nearer_than(const MapCloud& cloud, float z_m) {
  std::size_t n = 0;
  for (const cv::Point3f& p : cloud.points_m) n += p.z < z_m ? 1 : 0;
  return n;
}

}  // namespace

TEST_CASE("a voxel grid has the voxels, counts and centroids of its definition") {
  std::mt19937 source(7);
  std::vector<cv::Point3f> points;
  const auto number = [&] { return static_cast<float>(source()) / 4294967296.0F * 2 - 1; };
  for (int i = 0; i < 20000; ++i) points.emplace_back(number(), number(), 0.2F * number());
  points.emplace_back(kNan, 0.0F, 0.0F);
  VoxelGrid grid;
  std::vector<VoxelPoint> found;
  for (const double leaf : {0.01, 0.05, 3.0}) {
    struct Sums {
      double x = 0, y = 0, z = 0;
      unsigned n = 0;
    };
    std::map<std::array<int, 3>, Sums> cells;  // eq. 15-19 exactly
    const auto cell = [&](float v) { return static_cast<int>(std::floor(static_cast<double>(v) / leaf)); };
    for (std::size_t i = 0; i + 1 < points.size(); ++i) {
      const cv::Point3f& p = points[i];
      Sums& s = cells[{cell(p.x), cell(p.y), cell(p.z)}];
      s.x += static_cast<double>(p.x), s.y += static_cast<double>(p.y), s.z += static_cast<double>(p.z),
          ++s.n;
    }
    grid.set_leaf(leaf);
    grid.run(points, {}, found);
    CHECK(grid.outside() == 1);
    REQUIRE(found.size() == cells.size());
    const double quantum = leaf / 4096 + 1e-6;
    for (const VoxelPoint& p : found) {
      const auto at = cells.find({cell(p.x), cell(p.y), cell(p.z)});
      REQUIRE(at != cells.end());
      const Sums& s = at->second;
      REQUIRE(p.count == s.n);
      REQUIRE(std::abs(static_cast<double>(p.x) - s.x / s.n) < quantum);
      REQUIRE(std::abs(static_cast<double>(p.y) - s.y / s.n) < quantum);
      REQUIRE(std::abs(static_cast<double>(p.z) - s.z / s.n) < quantum);
    }
  }
  for (const double leaf : {0.0, -1.0, 1e9, std::numeric_limits<double>::quiet_NaN()})
    CHECK_THROWS_AS(VoxelGrid{leaf}, ConfigError);
}

TEST_CASE("back-projection is the pinhole's and leaves out what is no depth") {
  PixelRays rays;
  rays.set(camera_160(), {160, 120});
  cv::Mat depth(120, 160, CV_16UC1, cv::Scalar(10000));
  depth.at<std::uint16_t>(3, 5) = 0;
  DepthPoints points;
  REQUIRE(back_project_depth(depth, 1 / 5000.0, rays, DepthRange(), points));
  const std::size_t i = 7 * 160 + 40;
  CHECK(points.z[i] == doctest::Approx(2));
  CHECK(points.x[i] == doctest::Approx((40 - 79.5) / 130 * 2));
  CHECK(points.y[i] == doctest::Approx((7 - 59.5) / 130 * 2));
  CHECK(points.z[3 * 160 + 5] == 0.0F);
  CHECK_FALSE(back_project_depth(cv::Mat(120, 160, CV_8UC1), 1, rays, DepthRange(), points));
}

TEST_CASE("a doubled leaf is a map of that leaf from the start") {
  std::mt19937 source(3);
  std::vector<WorldPoint> points;
  const auto units = [&] { return static_cast<std::int32_t>(source() % 200000U) - 100000; };
  for (int i = 0; i < 5000; ++i)
    points.push_back(
        {{units(), units(), units()}, 1 + static_cast<std::uint32_t>(source() % 20U), 1, 2, 3, 0});
  VoxelMap doubled, direct(2);
  doubled.add(points.data(), 2000);
  doubled.coarsen();
  doubled.add(points.data() + 2000, 1000);
  doubled.coarsen();
  doubled.add(points.data() + 3000, 2000);
  direct.add(points.data(), points.size());
  CHECK(content(doubled) == content(direct));
}

TEST_CASE("a keyframe that is taken out was never in the map, and a moved one was always there") {
  StaticMap with, without, other;
  for (int i = 0; i < 5; ++i) {
    with.add(wall(i, 0.1 * i, i < 2));
    if (i != 1) without.add(wall(i, 0.1 * i, i < 2));
  }
  const auto all = content(with.voxels());
  CHECK(all != content(without.voxels()));
  CHECK(with.remove(1));
  CHECK_FALSE(with.remove(1));
  CHECK(content(with.voxels()) == content(without.voxels()));
  with.add(wall(1, 0.7, true));
  CHECK(content(with.voxels()) != all);
  Pose back;
  back.translation_m = {0.1, 0, 0};
  CHECK(with.move(1, back) == true);
  MapFrame right = wall(1, 0.7, true);
  right.T_world_camera = back;
  without.add(right);
  CHECK(content(with.voxels()) == content(without.voxels()));
  CHECK(with.cloud().points_m == without.cloud().points_m);
}

TEST_CASE("each point of the cloud knows the keyframes that it came from") {
  MappingParams params;
  params.carve.enabled = false;
  StaticMap map(params);
  for (int i = 0; i < 4; ++i) {
    MapFrame frame = wall(10 + i, 0.3 * i, false);
    frame.timestamp_s = 0.5 * i;
    frame.depth.setTo(2 + 0.5 * (i % 2));  // keyframes 10 and 12 see 2 m, 11 and 13 see 2.5 m
    map.add(frame);
  }
  const auto check = [&](const std::vector<int>& at_2_m, const std::vector<int>& at_2_5_m) {
    const MapCloud cloud = map.cloud();
    const MapSources sources = map.sources();
    CHECK(sources.complete);
    REQUIRE(sources.size() == cloud.size());
    CHECK(nearer_than(cloud, 2.2F) > 3000);
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const cv::Point3f& p = cloud.points_m[i];
      std::vector<std::int64_t> wanted;
      bool doubtful = false;
      for (const int k : p.z < 2.2F ? at_2_m : at_2_5_m) {
        const float u = 130 * (p.x - 0.3F * static_cast<float>(k)) / p.z + 79.5F;
        if (u > -0.5F && u < 159.5F) wanted.push_back(10 + k);
        doubtful = doubtful || std::abs(u) < 3 || std::abs(u - 159) < 3;
      }
      if (doubtful) continue;
      const auto ids_of = [&](std::size_t k) {
        return sources.ids.begin() + static_cast<std::ptrdiff_t>(sources.first[k]);
      };
      REQUIRE(std::vector<std::int64_t>(ids_of(i), ids_of(i + 1)) == wanted);
      REQUIRE(sources.stamps_s(i)[0] == 0.5 * static_cast<double>(wanted[0] - 10));
    }
  };
  check({0, 2}, {1, 3});
  map.remove(12);
  check({0}, {1, 3});
}

TEST_CASE("who stood there and left is removed, who comes is held back") {
  StaticMap leaves, comes;
  for (int i = 0; i < 6; ++i) {
    leaves.add(wall(i, 0.02 * i, i < 2));
    comes.add(wall(i, 0.02 * i, i >= 4));
    if (i == 1) CHECK(nearer_than(leaves.cloud(), 2) > 200);
  }
  CHECK(nearer_than(leaves.cloud(), 2) == 0);
  CHECK(nearer_than(comes.cloud(), 2) == 0);
  CHECK(nearer_than(leaves.cloud(), 4) > 5000);
  MappingParams params;
  params.carve.enabled = false;
  StaticMap keeps(params);
  for (int i = 0; i < 6; ++i) keeps.add(wall(i, 0.02 * i, i < 2));
  CHECK(nearer_than(keeps.cloud(), 2) > 200);
}

TEST_CASE("what few keyframes saw goes with the neighbours that were seen through, to the letter") {
  std::mt19937 source(11);
  const CarveParams params;
  std::size_t spread = 0;
  for (int round = 0; round < 30; ++round) {
    VoxelMap map;
    for (int k = 0; k < 150; ++k) {
      const auto cell = [&] { return static_cast<std::int32_t>(source() % 8U) * 4096 - 12288; };
      const WorldPoint p{{cell(), cell(), cell()}, 1, 0, 0, 0, static_cast<std::uint8_t>(source() % 2U)};
      map.add(&p, 1);
    }
    for (VoxelVotes& v : map.votes()) {
      v.seen = static_cast<std::uint16_t>(source() % 6U);
      v.through = source() % 8U == 0 ? 1 : 0;
    }
    std::vector<bool> gone(map.size());
    std::size_t begin = 0, end = 0;
    for (std::size_t i = 0; i < map.size(); ++i) {
      const VoxelVotes& v = map.votes()[i];
      gone[i] = v.through >= params.min_views && v.seen < CarveParams::kSeenPerThrough * v.through;
      begin += gone[i] ? 1 : 0;
    }
    for (bool changed = true; changed;) {
      changed = false;
      for (std::size_t i = 0; i < map.size(); ++i) {
        int all = 0, without = 0;
        for (std::size_t j = 0; j < map.size(); ++j) {
          bool near = j != i && VoxelKey::label(map.keys()[i]) == VoxelKey::label(map.keys()[j]);
          for (int a = 0; a < 3; ++a)
            near = near && std::abs(VoxelKey::axis(map.keys()[i], a) - VoxelKey::axis(map.keys()[j], a)) <= 2;
          all += near ? 1 : 0;
          without += near && gone[j] ? 1 : 0;
        }
        if (gone[i] || map.votes()[i].seen > CarveParams::kSpreadMaxSeen) continue;
        if (without == 0 || without < CarveParams::kSpreadShare * all) continue;
        gone[i] = changed = true;
      }
    }
    const Carving carving(map, params);
    for (std::size_t i = 0; i < map.size(); ++i) {
      REQUIRE(carving.gone(i) == gone[i]);
      end += gone[i] ? 1 : 0;
    }
    spread += end - begin;
  }
  CHECK(spread > 100);
}

TEST_CASE("lonely voxels are removed, a wall stays") {
  VoxelMap map;
  const auto put = [&](std::int32_t x, std::int32_t y, std::int32_t z) {
    const WorldPoint p{{x * 4096 + 2048, y * 4096 + 2048, z * 4096 + 2048}, 1, 0, 0, 0, 0};
    map.add(&p, 1);
  };
  for (int y = -20; y < 20; ++y)
    for (int x = -20; x < 20; ++x) put(x, y, 50);
  put(0, 0, 40), put(1, 0, 40), put(-30, 0, 50);
  // On the wall: four neighbours at 1, four at 1.41, mean 1.21. The corners have 1.71, the largest of the
  // 1600. The isolated voxels have 2 and 1.88.
  // The mean is 1.23 and the deviation 0.08, so the limit is 1.63: corners are also removed.
  OutlierParams params;
  params.sigmas = 7;
  std::vector<std::uint32_t> order = voxels_in_order(map, [](std::uint32_t) { return true; });
  OutlierFilter(params).run(map, order);
  CHECK(order.size() == 1600);
  for (const std::uint32_t i : order) CHECK(std::abs(VoxelKey::axis(map.keys()[i], 0)) <= 20);
  params.enabled = false;
  order.push_back(0);
  OutlierFilter(params).run(map, order);
  CHECK(order.size() == 1601);
}

TEST_CASE("lonely voxels are those that comparing all with all finds") {
  std::mt19937 source(5);
  for (int round = 0; round < 10; ++round) {
    VoxelMap map(round % 2);
    for (int k = 0; k < 400; ++k) {
      const auto units = [&] { return static_cast<std::int32_t>(source() % (9U << 12U)) - (4 << 12); };
      const WorldPoint p{
          {units(), units(), units() / 3},         1 + static_cast<std::uint32_t>(source() % 3U), 0, 0, 0,
          static_cast<std::uint8_t>(source() % 2U)};
      map.add(&p, 1);
    }
    OutlierParams params;
    params.neighbours = 1 + round;
    params.sigmas = 1;
    const double leaf_units = 4096 << map.level();
    std::vector<double> mean;
    for (std::size_t i = 0; i < map.size(); ++i) {
      std::vector<double> distances(64, 2.0);
      for (std::size_t j = 0; j < map.size(); ++j) {
        if (i == j || VoxelKey::label(map.keys()[i]) != VoxelKey::label(map.keys()[j])) continue;
        double d2 = 0;
        for (std::size_t a = 0; a < 3; ++a)
          d2 += std::pow((voxel_units(map.voxels()[i], a) - voxel_units(map.voxels()[j], a)) / leaf_units, 2);
        distances.push_back(std::min(2.0, std::sqrt(d2)));
      }
      std::sort(distances.begin(), distances.end());
      double sum = 0;
      for (int k = 0; k < params.neighbours; ++k) sum += distances[static_cast<std::size_t>(k)];
      mean.push_back(sum / params.neighbours);
    }
    double average = 0, variance = 0;
    for (const double m : mean) average += m / static_cast<double>(mean.size());
    for (const double m : mean) variance += (m - average) * (m - average) / static_cast<double>(mean.size());
    const double limit = average + std::sqrt(variance);
    std::vector<std::uint32_t> order = voxels_in_order(map, [](std::uint32_t) { return true; });
    OutlierFilter(params).run(map, order);
    std::vector<bool> stays(map.size());
    for (const std::uint32_t i : order) stays[i] = true;
    std::size_t lonely = 0;
    for (std::size_t i = 0; i < map.size(); ++i) {
      lonely += mean[i] > limit ? 1 : 0;
      if (std::abs(mean[i] - limit) > 1e-5) REQUIRE(stays[i] == (mean[i] < limit));
    }
    CHECK(lonely > 0);
  }
}

TEST_CASE("masks and clusters of dynamic features cut their object out") {
  MapFrame frame = wall(0, 0, true);
  frame.moving_mask = cv::Mat(60, 80, CV_8UC1, cv::Scalar(0));
  frame.moving_mask(cv::Rect(20, 8, 40, 50)).setTo(1);
  StaticMap masked;
  CHECK(masked.add(frame).cut_pixels > 5000);
  CHECK(nearer_than(masked.cloud(), 2) == 0);

  frame.moving_mask = cv::Mat();
  const std::vector<cv::Point2f> features{{70, 50}, {80, 55}, {75, 60}, {85, 65}, {90, 52}};
  frame.moving_px = features;
  StaticMap grown;
  CHECK(grown.add(frame).cut_pixels > 5000);
  CHECK(nearer_than(grown.cloud(), 2) == 0);
  frame.moving_px = Span<const cv::Point2f>(features.data(), 2);  // too few for a cluster
  StaticMap few;
  CHECK(few.add(frame).cut_pixels == 0);
}

TEST_CASE("static features bound what is cut out, and outvote a lonely dynamic one") {
  MapFrame frame = wall(0, 0, false);
  // A wall at 3 m, 23 mm per pixel.
  // Five dynamic features at x = 30 to 34, static ones everywhere from x = 50.
  const std::vector<cv::Point2f> moving{{30, 60}, {31, 61}, {32, 60}, {33, 61}, {34, 60}};
  std::vector<cv::Point2f> still;
  for (int y = 2; y < 120; y += 6)
    for (int x = 50; x < 160; x += 6) still.emplace_back(static_cast<float>(x), static_cast<float>(y));
  CutParams params;
  params.band_px = 0;
  DepthCut cut(params);
  frame.moving_px = moving;
  cut.run(frame.depth, frame);
  CHECK(cut.moving().at<std::uint8_t>(60, 46) != 0);  // 0.6 m are 26 px: as far as x = 60
  CHECK(cut.moving().at<std::uint8_t>(60, 58) != 0);
  frame.still_px = still;
  cut.run(frame.depth, frame);
  CHECK(cut.moving().at<std::uint8_t>(60, 32) != 0);
  CHECK(cut.moving().at<std::uint8_t>(60, 40) != 0);
  CHECK(cut.moving().at<std::uint8_t>(60, 46) == 0);  // 12 steps from 34, 6 from (50, 62)
  // Among static ones, 0.3 m or 13 px around: five against a dozen and more.
  const std::vector<cv::Point2f> wrong{{100, 60}, {101, 61}, {102, 60}, {103, 61}, {104, 60}};
  frame.moving_px = wrong;
  cut.run(frame.depth, frame);
  CHECK(cut.cut_pixels() == 0);
  frame.still_px = {};
  cut.run(frame.depth, frame);
  CHECK(cut.cut_pixels() > 0);
}

TEST_CASE("depths that are too far for the map still show what is free") {
  StaticMap map;
  for (int i = 0; i < 4; ++i) {
    MapFrame frame = wall(i, 0.02 * i, false);
    frame.depth.setTo(7);  // the map ends at 5 m
    if (i == 0) frame.depth(cv::Rect(60, 20, 40, 90)).setTo(1.5);
    const MapReport report = map.add(frame);
    CHECK(report.pixels == (i == 0 ? 40 * 90 : 0));
    if (i == 0) CHECK(nearer_than(map.cloud(), 2) > 200);
  }
  CHECK(map.cloud().size() == 0);
}

TEST_CASE("key regions are kept on the fine grid, coarse elsewhere") {
  std::vector<Detection> found(1);
  found[0].class_name = "book";
  found[0].box = {60, 40, 30, 30};
  MapFrame frame = wall(0, 0, false);
  frame.detections = found;
  MappingParams params;
  params.leaf_m = 0.1;
  params.outliers.enabled = false;  // the corners of a small patch are isolated
  StaticMap map(params);
  const MapReport report = map.add(frame);
  // 30 pixels of 23.1 mm span 27 or 28 cells of 25 mm, or one less where centres fall on a face.
  CHECK(report.key_points >= 26 * 26);
  CHECK(report.key_points <= 29 * 29);
  std::size_t books = 0;
  for (const int label : map.cloud().classes) books += label == 1 ? 1 : 0;
  CHECK(books == map.key_voxels().size());
}

TEST_CASE("memory is bounded: the leaf doubles, the oldest keyframes become permanent") {
  MappingParams params;
  params.max_voxels = 3000;
  params.max_keyframe_mb = 0.3;
  StaticMap map(params);
  bool doubled = false;
  std::size_t permanent = 0;
  for (int i = 0; i < 4; ++i) {
    const MapReport report = map.add(wall(i, 0.3 * i, false));
    doubled = doubled || report.leaf_doubled;
    permanent += report.made_permanent.size();
  }
  CHECK(doubled);
  CHECK(map.state().voxels <= 3000);
  CHECK(permanent > 0);
  CHECK(map.state().permanent_keyframes == permanent);
  CHECK(map.state().keyframe_bytes <= 300000);
  CHECK_FALSE(map.remove(0));
}

namespace {

/// A wall at z = 3, a floor at y = 1 and a wall at x = 1.3, viewed from (x, y, 0).
MapFrame corner(std::int64_t id, double x_m, double y_m) {
  MapFrame frame = wall(id, x_m, false);
  frame.T_world_camera.translation_m = {x_m, y_m, 0};
  for (int v = 0; v < 120; ++v)
    for (int u = 0; u < 160; ++u) {
      const double x = (u - 79.5) / 130, y = (v - 59.5) / 130;
      double z = 3;
      if (y > 0) z = std::min(z, (1 - y_m) / y);
      if (x > 0) z = std::min(z, (1.3 - x_m) / x);
      frame.depth.at<float>(v, u) = static_cast<float>(z);
    }
  return frame;
}
double offset_m(const Pose& a, const Pose& b) {
  return (a.t() - b.t()).norm();
}

}  // namespace

TEST_CASE("a keyframe 2 cm and half a degree off is aligned with the map, one that says too little is not") {
  MappingParams params;
  params.registration.enabled = true;
  StaticMap map(params);
  CHECK_FALSE(map.add(corner(0, 0, 0)).registered);  // there is no map yet
  MapFrame frame = corner(1, 0.1, -0.05);
  const Pose right = frame.T_world_camera;
  const double turn = 0.5 * 3.14159265 / 180;
  frame.T_world_camera.rotation = {std::cos(turn),  0, std::sin(turn), 0, 1, 0,
                                   -std::sin(turn), 0, std::cos(turn)};
  frame.T_world_camera.translation_m = {right.translation_m[0] + 0.012, right.translation_m[1] - 0.012,
                                        right.translation_m[2] + 0.0106};
  CHECK(offset_m(frame.T_world_camera, right) > 0.0199);
  const MapReport report = map.add(frame);
  REQUIRE(report.registered);
  CHECK(offset_m(report.T_world_camera, right) < 0.001);
  CHECK(std::abs(report.T_world_camera.rotation[2]) < 0.0005);
  CHECK(is_rigid(report.T_world_camera));

  StaticMap again(params);
  again.add(corner(0, 0, 0));
  CHECK(again.add(frame).T_world_camera.translation_m == report.T_world_camera.translation_m);
  map.move(1, right);  // exactly
  again.remove(1);
  params.registration.enabled = false;
  StaticMap plain(params);
  plain.add(corner(0, 0, 0));
  CHECK(content(again.voxels()) == content(plain.voxels()));
  frame.T_world_camera = right;
  plain.add(frame);
  CHECK(content(map.voxels()) == content(plain.voxels()));
}

TEST_CASE("a single wall leaves the pose as it is, and so does what is too far off") {
  MappingParams params;
  params.registration.enabled = true;
  StaticMap map(params);
  map.add(wall(0, 0, false));
  MapFrame frame = wall(1, 0.1, false);
  frame.T_world_camera.translation_m[2] = 0.01;
  const MapReport report = map.add(frame);
  CHECK_FALSE(report.registered);
  CHECK(offset_m(report.T_world_camera, frame.T_world_camera) == 0);
  params.registration.max_correction_m = 0.01;
  StaticMap bounded(params);
  bounded.add(corner(0, 0, 0));
  frame = corner(1, 0, 0);
  frame.T_world_camera.translation_m[2] = 0.02;
  CHECK_FALSE(bounded.add(frame).registered);
  frame = corner(2, 0, 0);
  frame.depth.rowRange(0, 115).setTo(0);
  CHECK_FALSE(bounded.add(frame).registered);
}

TEST_CASE("a long way does not take more memory than the bounds") {
  MappingParams params;
  params.leaf_m = 0.05;
  params.max_voxels = 20000;
  params.max_keyframe_mb = 1;
  StaticMap map(params);
  std::size_t most = 0;
  for (int i = 0; i < 120; ++i) {
    MapFrame frame = wall(i, 0.5 * i, false);
    const MapReport report = map.add(frame);
    CHECK(report.used);
    most = std::max(most, map.state().voxel_bytes + map.state().keyframe_bytes);
    REQUIRE(map.state().voxels + map.state().key_voxels <= 20000);
  }
  CHECK(map.state().permanent_keyframes > 80);
  CHECK(map.state().leaf_m > 0.05);
  // Voxels: 80 bytes each, lists up to twice that while they grow by a keyframe's points; table: 4 bytes, a
  // quarter full at least.
  CHECK(most < 2 * 80 * 30000 + 16 * 30000 + 1000000);
}

TEST_CASE("odd frames are skipped with a reason, wrong settings are named") {
  StaticMap map;
  const auto skipped = [&](const MapFrame& frame) {
    const MapReport report = map.add(frame);
    return !report.used && !report.note.empty() && map.voxels().size() == 0;
  };
  MapFrame frame = wall(0, 0, false);
  CHECK(skipped(MapFrame()));
  frame.depth = cv::Mat(120, 160, CV_8UC1, cv::Scalar(1));
  CHECK(skipped(frame));
  frame = wall(0, 0, false), frame.camera.width_px = 640, frame.camera.height_px = 480;
  CHECK(skipped(frame));
  frame = wall(0, 0, false), frame.T_world_camera.rotation[0] = 2;
  CHECK(skipped(frame));
  frame = wall(0, 0, false), frame.T_world_camera.translation_m[1] = static_cast<double>(kNan);
  CHECK(skipped(frame));
  frame = wall(0, 0, false), frame.depth.setTo(kNan);
  CHECK(map.add(frame).used);
  CHECK(map.voxels().size() == 0);
  MappingParams params;
  for (const double leaf : {0.0, static_cast<double>(kNan), -1.0, 9.0}) {
    params.leaf_m = leaf;
    CHECK_THROWS_AS(StaticMap{params}, ConfigError);
  }
}

TEST_CASE("the map of the thread is the map of the same calls; a full queue drops and says so") {
  StaticMap plain;
  MappingThread thread;
  for (int i = 0; i < 5; ++i) {
    MapFrame frame = wall(i, 0.1 * i, i < 2);
    plain.add(frame);
    CHECK(thread.add(frame));
    frame.depth.setTo(0);  // the host reuses its buffers
  }
  Pose elsewhere;
  elsewhere.translation_m = {0, 0.2, 0};
  plain.remove(1), thread.remove(1);
  plain.move(2, elsewhere), thread.move(2, elsewhere);
  const MapCloud one = plain.cloud(), other = thread.cloud();
  CHECK(one.size() > 5000);
  CHECK(one.points_m == other.points_m);
  CHECK(thread.status().fused == 5);
  MappingThread none(MappingParams(), 0);
  CHECK_FALSE(none.add(wall(0, 0, false)));
  CHECK(none.status().dropped == 1);
}

TEST_CASE("a picture shows the nearer of two points, and the overview looks down on the scene") {
  MapCloud cloud;
  cloud.points_m = {{0, 0, 2}, {0, 0, 1}};
  cloud.colours.emplace_back(255, 0, 0);
  cloud.colours.emplace_back(0, 0, 255);
  const cv::Mat picture = render_cloud(cloud, 0.05, camera_160(), {160, 120}, Pose());
  CHECK(picture.at<cv::Vec3b>(60, 80) == cv::Vec3b(0, 0, 255));
  CHECK(picture.at<cv::Vec3b>(5, 5) == cv::Vec3b(40, 40, 40));
  StaticMap map;
  map.add(wall(0, 0, false));
  const Pose above = overview_pose(map.cloud(), Pose(), camera_160(), {160, 120});
  CHECK(is_rigid(above));
  CHECK(above.translation_m[1] < 0);  // y points down
  CHECK(above.rotation[5] > 0.3);     // the optical axis points downwards
}

TEST_CASE("the table of docs/reference/mapping.md is that of the parameters") {
  dynfilter_test::check_parameter_tables("docs/reference/mapping.md",
                                         {{"mapping", dynfilter_test::parameter_table<MappingParams>()}});
}

}  // namespace static_map_test
