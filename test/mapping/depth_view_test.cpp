// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <dynfilter/geometry/undistort.hpp>
#include <dynfilter/mapping/depth_view.hpp>
#include <random>
#include <set>

#include "doctest/doctest.h"

namespace depth_view_test {

using namespace dynfilter;
using namespace dynfilter::mapping;

namespace {

enum class Sight { Nothing, Seen, Through };

struct View {
  Camera camera;
  cv::Mat depth_m, moving;
};

/// A wall with steps, holes and a mover in front; nearly all blocks contain some of it.
View random_view(unsigned seed, bool distorted) {
  std::mt19937 source(seed);
  View view;
  view.camera.fx_px = 70, view.camera.fy_px = 72, view.camera.cx_px = 41, view.camera.cy_px = 30;
  if (distorted) view.camera.distortion = {-0.2, 0.05, 0.001, -0.002};
  view.depth_m = cv::Mat(63, 82, CV_32FC1);
  view.moving = cv::Mat::zeros(view.depth_m.size(), CV_8UC1);
  for (int y = 0; y < view.depth_m.rows; ++y)
    for (int x = 0; x < view.depth_m.cols; ++x) {
      float z = x < 30 ? 2.0F : 3.0F + 0.01F * static_cast<float>(y);
      if (x > 50 && x < 66 && y > 10 && y < 40) z = 1.2F, view.moving.at<std::uint8_t>(y, x) = 1;
      if (source() % 40U == 0 || (x > 20 && x < 28 && y > 44)) z = 0;
      view.depth_m.at<float>(y, x) = z;
    }
  return view;
}

int measured_in(const View& view, int bx, int by, float& nearest_m) {
  int n = 0;
  nearest_m = 1e9F;
  for (int y = 4 * by; y < 4 * by + 4; ++y)
    for (int x = 4 * bx; x < 4 * bx + 4; ++x) {
      const float z = view.depth_m.at<float>(y, x);
      if (z > 0) ++n, nearest_m = std::min(nearest_m, z);
    }
  return n;
}

/// In front of all depths in this block and the eight around it, each at least three quarters full.
bool through(const View& view, int bx, int by, double z, double margin_m) {
  const int columns = view.depth_m.cols / 4, rows = view.depth_m.rows / 4;
  if (bx < 1 || by < 1 || bx + 1 >= columns || by + 1 >= rows) return false;
  for (int y = by - 1; y <= by + 1; ++y)
    for (int x = bx - 1; x <= bx + 1; ++x) {
      float nearest_m = 0;
      if (measured_in(view, x, y, nearest_m) < 12) return false;
      const auto d = static_cast<double>(nearest_m);
      if (!(z + margin_m < d - CarveParams::kNoiseSigmas * DepthNoise().sigma_m(d))) return false;
    }
  return true;
}

/// Between the smallest and the largest static depth in this block.
bool seen(const View& view, int bx, int by, double z, double margin_m) {
  double low = 1e9, high = 0;
  for (int y = 4 * by; y < 4 * by + 4; ++y)
    for (int x = 4 * bx; x < 4 * bx + 4; ++x) {
      const auto d = static_cast<double>(view.depth_m.at<float>(y, x));
      if (d > 0 && view.moving.at<std::uint8_t>(y, x) == 0) low = std::min(low, d), high = std::max(high, d);
    }
  const double reach_m = margin_m + CarveParams::kNoiseSigmas * DepthNoise().sigma_m(z);
  return high > 0 && std::min(std::abs(z - low), std::abs(z - high)) <= reach_m;
}

Sight by_definition(const View& view, const Eigen::Vector3d& p, double leaf_m, double off_px, double off_m) {
  const double z = p.z() + off_m;
  if (!(p.z() > 0) || std::abs(p.x()) > 2 * p.z() || std::abs(p.y()) > 2 * p.z()) return Sight::Nothing;
  const cv::Point2f px =
      project(view.camera,
              cv::Point3f(static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())));
  const cv::Point2f seen_px = distort_point(view.camera, px);
  const double u = static_cast<double>(seen_px.x) + 0.5 + off_px,
               v = static_cast<double>(seen_px.y) + 0.5 + off_px;
  const int columns = view.depth_m.cols / 4, rows = view.depth_m.rows / 4;
  if (!(u >= 0 && v >= 0 && u < 4 * columns && v < 4 * rows)) return Sight::Nothing;
  const int bx = static_cast<int>(u) / 4, by = static_cast<int>(v) / 4;
  const double margin_m = CarveParams::kMargin_m + 0.866 * leaf_m;
  if (through(view, bx, by, z, margin_m)) return Sight::Through;
  return seen(view, bx, by, z, margin_m) ? Sight::Seen : Sight::Nothing;
}

}  // namespace

// Depths are stored in millimetres and positions in floats.
// Results may differ where a millimetre or a hundredth of a pixel decides.
TEST_CASE("what a view says of voxels is what its pixels say, to the letter") {
  for (const bool distorted : {false, true}) {
    const View view = random_view(distorted ? 3 : 4, distorted);
    DepthView summary;
    summary.build(view.depth_m, view.moving, view.camera);
    const double leaf_m = 0.02;
    Pose T_world_camera;
    T_world_camera.translation_m = {0.3, -0.2, 0.1};
    std::mt19937 source(9);
    KeyList keys;
    const auto cell = [&](double low_m, double high_m) {
      const double at_m = low_m + (high_m - low_m) * static_cast<double>(source() % 65536U) / 65536;
      return static_cast<std::int32_t>(std::floor(at_m / leaf_m));
    };
    for (int k = 0; k < 40001; ++k) keys.push_back(VoxelKey::pack(cell(-3, 3), cell(-3, 3), cell(-0.5, 4.5)));
    std::vector<Sight> found(keys.size(), Sight::Nothing);
    std::size_t visited = 0;
    summary.visit(keys, 5, leaf_m, T_world_camera, [&](std::size_t i, int seen, int through) {
      CHECK(i == 5 + visited++);
      CHECK(seen + through <= 1);
      if (seen + through > 0) found[i] = seen > 0 ? Sight::Seen : Sight::Through;
    });
    CHECK(visited == keys.size() - 5);
    int compared[3] = {};
    for (std::size_t i = 5; i < keys.size(); ++i) {
      Eigen::Vector3d centre;
      for (int a = 0; a < 3; ++a) centre[a] = (VoxelKey::axis(keys[i], a) + 0.5) * leaf_m;
      const Eigen::Vector3d p = inverse(T_world_camera).R() * centre + inverse(T_world_camera).t();
      std::set<Sight> expected;
      for (const double off_px : {-0.01, 0.0, 0.01})
        for (const double off_m : {-0.0011, 0.0, 0.0011})
          expected.insert(by_definition(view, p, leaf_m, off_px, off_m));
      CHECK(expected.count(found[i]) == 1);
      if (expected.size() == 1) ++compared[static_cast<int>(found[i])];
    }
    for (const int n : compared) CHECK(n > 200);
  }
}

// With strong barrel distortion the polynomial turns back.
// Points far outside would then appear in the image.
TEST_CASE("a view says nothing of what lies far beside it") {
  View view = random_view(5, true);
  view.camera.distortion = {-0.3, 0, 0, 0};
  view.depth_m.setTo(3);
  view.moving.setTo(0);
  DepthView summary;
  summary.build(view.depth_m, view.moving, view.camera);
  const double leaf_m = 0.01;
  KeyList keys;
  // x (1 - 0.3 x^2) is 0.16, 0.12, 0.05 and 0.01 there.
  for (const double tangent : {1.74, 1.76, 1.8, 1.82})
    keys.push_back(VoxelKey::pack(static_cast<std::int32_t>(tangent * 100), 0, 100));
  keys.push_back(VoxelKey::pack(5, 0, 100));
  std::vector<int> votes;
  summary.visit(keys, 0, leaf_m, Pose(),
                [&](std::size_t, int seen, int through) { votes.push_back(seen + 2 * through); });
  CHECK(votes == std::vector<int>{0, 0, 0, 0, 2});
}

TEST_CASE("a view of nothing says nothing") {
  KeyList keys;
  keys.push_back(VoxelKey::pack(0, 0, 100));
  keys.push_back(VoxelKey::pack(0, 0, -100));
  DepthView never_built, tiny;
  tiny.build(cv::Mat(3, 3, CV_32FC1, cv::Scalar(2)), cv::Mat::zeros(3, 3, CV_8UC1),
             random_view(1, false).camera);
  for (const DepthView* view : {&never_built, &tiny}) {
    int votes = 0;
    view->visit(keys, 0, 0.01, Pose(), [&](std::size_t, int seen, int through) { votes += seen + through; });
    CHECK(votes == 0);
  }
}

// Reference: the same keys, each batch with one key that extends its box to the entire scene.
TEST_CASE("batches that a view does not look at are those it says nothing of") {
  for (const bool distorted : {false, true}) {
    const View view = random_view(distorted ? 6 : 7, distorted);
    DepthView summary;
    summary.build(view.depth_m, view.moving, view.camera);
    std::mt19937 source(8);
    const auto below = [&](int n) { return static_cast<std::int32_t>(source() % static_cast<unsigned>(n)); };
    KeyList keys, anywhere;
    for (int batch = 0; batch < 2000; ++batch) {
      const std::int32_t corner[] = {below(800) - 400, below(800) - 400, below(1000) - 300};
      const int side = 1 + below(40);
      for (std::size_t k = 0; k < KeyList::kBatch; ++k)
        keys.push_back(
            VoxelKey::pack(corner[0] + below(side), corner[1] + below(side), corner[2] + below(side)));
    }
    for (const std::uint64_t key : keys.keys()) anywhere.push_back(key);
    for (std::size_t i = 0; i < keys.size(); i += KeyList::kBatch)
      for (const std::int32_t far : {-30000, 30000}) {
        anywhere.replace(i, VoxelKey::pack(far, far, far));
        anywhere.replace(i, keys[i]);
      }
    std::size_t voted = 0;
    for (int round = 0; round < 10; ++round) {
      const double turn = 0.15 * round, leaf_m = round % 2 == 0 ? 0.01 : 0.02;
      Pose T_world_camera;
      T_world_camera.rotation = {std::cos(turn),  0, std::sin(turn), 0, 1, 0,
                                 -std::sin(turn), 0, std::cos(turn)};
      T_world_camera.translation_m = {0.1 * round, 0.2, -0.3};
      std::vector<int> votes(keys.size(), 0), expected(keys.size(), 0);
      std::size_t visited = 0, all = 0;
      summary.visit(keys, 3, leaf_m, T_world_camera, [&](std::size_t i, int seen, int through) {
        ++visited;
        votes[i] = seen + 2 * through;
      });
      summary.visit(anywhere, 3, leaf_m, T_world_camera, [&](std::size_t i, int seen, int through) {
        ++all;
        expected[i] = seen + 2 * through;
      });
      CHECK(all == keys.size() - 3);
      CHECK(visited * 2 < all);
      CHECK(votes == expected);
      voted += expected.size() - static_cast<std::size_t>(std::count(expected.begin(), expected.end(), 0));
    }
    CHECK(voted > 10000);
  }
}

TEST_CASE("the box of a batch holds its keys, whatever was replaced") {
  std::mt19937 source(10);
  const auto key = [&] {
    const auto cell = [&] { return static_cast<std::int32_t>(source() % 2000U) - 1000; };
    return VoxelKey::pack(cell(), cell(), cell());
  };
  KeyList list;
  std::vector<std::uint64_t> keys;
  for (int round = 0; round < 5000; ++round) {
    if (source() % 3 != 0 || keys.empty()) {
      keys.push_back(key());
      list.push_back(keys.back());
    } else if (source() % 2 == 0) {
      const std::size_t i = source() % keys.size();
      keys[i] = key();
      list.replace(i, keys[i]);
    } else {
      keys.pop_back();
      list.pop_back();
    }
  }
  REQUIRE(list.keys() == keys);
  for (std::size_t i = 0; i < keys.size(); ++i)
    for (int a = 0; a < 3; ++a) {
      CHECK(list.box_of(i).low[static_cast<std::size_t>(a)] <= VoxelKey::axis(keys[i], a));
      CHECK(list.box_of(i).high[static_cast<std::size_t>(a)] >= VoxelKey::axis(keys[i], a));
    }
}

}  // namespace depth_view_test
