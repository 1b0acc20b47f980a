// SPDX-License-Identifier: MIT
#include <dynfilter/core/error.hpp>

#include "io/tum_folder.hpp"
#include "render/map_truth.hpp"
#include "render/scene_file.hpp"

#include "doctest/doctest.h"

using namespace dynfilter;
using namespace dynfilter::render;

namespace map_truth_test {

TEST_CASE("nearest point on a triangle: face, edges, corners") {
  const Eigen::Vector3f a(0, 0, 0), b(1, 0, 0), c(0, 1, 0);
  const auto near = [&](float x, float y, float z) -> Eigen::Vector3f {
    return nearest_on_triangle({x, y, z}, a, b, c);
  };
  CHECK((near(0.2F, 0.3F, 0.7F) - Eigen::Vector3f(0.2F, 0.3F, 0)).norm() < 1e-6F);
  CHECK((near(-1, -1, 1) - a).norm() < 1e-6F);
  CHECK((near(3, -1, 0) - b).norm() < 1e-6F);
  CHECK((near(-1, 3, 0) - c).norm() < 1e-6F);
  CHECK((near(0.5F, -2, 1) - Eigen::Vector3f(0.5F, 0, 0)).norm() < 1e-6F);
  CHECK((near(-2, 0.5F, 1) - Eigen::Vector3f(0, 0.5F, 0)).norm() < 1e-6F);
  CHECK((near(1, 1, 0) - Eigen::Vector3f(0.5F, 0.5F, 0)).norm() < 1e-6F);
}

TEST_CASE("the tree finds what looking at every triangle finds") {
  const Scene scene = make_scene("static_desk", 1);
  MeshDistance tree;
  for (std::size_t i = 0; i < 12; ++i) tree.add(scene.surroundings->models[i]);
  tree.build();
  Random random(5, 1);
  for (int i = 0; i < 60; ++i) {
    const Eigen::Vector3f p(static_cast<float>(random.uniform(-3, 3)),
                            static_cast<float>(random.uniform(-3, 3)),
                            static_cast<float>(random.uniform(0, 2.5)));
    float best = 1e9F;
    for (std::size_t m = 0; m < 12; ++m)
      for (const Face& f : scene.surroundings->models[m].faces) {
        const auto& v = scene.surroundings->models[m].vertices;
        const Eigen::Vector3f q = nearest_on_triangle(p, v[f.corner[0]].position_m, v[f.corner[1]].position_m,
                                                      v[f.corner[2]].position_m);
        best = std::min(best, (p - q).norm());
      }
    CHECK(tree.nearest(p, 100).distance_m == doctest::Approx(best).epsilon(1e-4));
    if (best > 0.5F) CHECK(std::isinf(tree.nearest(p, 0.4F).distance_m));
  }
  CHECK(std::isinf(MeshDistance().nearest({0, 0, 0}, 1).distance_m));
}

TEST_CASE(
    "true depth of the room is on the static surface, that of people on a mover, and old people are ghosts") {
  SequenceOptions options;
  options.scene = "walking_static", options.seed = 3, options.perfect_depth = true, options.frames = 40;
  SequenceRenderer renderer(options);
  const RenderedFrame frame = renderer.frame(30);
  MapTruth truth(options.scene, options.seed);
  CHECK(truth.distance_from(frame.timestamp_s, frame.T_world_camera) < 1e-6);
  CHECK(truth.distance_from(frame.timestamp_s + 1, frame.T_world_camera) > 1e-6);
  truth.see(frame.depth, 1 / kDepthUnitsPerM, frame.truth.labels, renderer.camera(), frame.T_world_camera, 2);

  std::vector<cv::Point3f> room, people;
  const Eigen::Isometry3d T = frame.T_world_camera.isometry();
  const Camera& camera = renderer.camera();
  for (int y = 1; y < 480; y += 2)
    for (int x = 1; x < 640; x += 2) {
      const double z = static_cast<double>(frame.true_depth_m.at<float>(y, x));
      if (z <= 0) continue;
      const Eigen::Vector3d p = T * Eigen::Vector3d((x - camera.cx_px) / camera.fx_px * z,
                                                    (y - camera.cy_px) / camera.fy_px * z, z);
      (frame.truth.labels.at<std::uint8_t>(y, x) > 0 ? people : room)
          .emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z()));
    }
  REQUIRE(people.size() > 1000);
  const std::vector<double> now{frame.timestamp_s}, later{frame.timestamp_s + 0.5};
  const MapQuality clean = truth.judge(room, [&](std::size_t) { return now; });
  CHECK(clean.ghosts == 0);
  CHECK(clean.astray == 0);
  CHECK(clean.error_p95_m < 1e-3);
  CHECK(clean.coverage() > 0.95);
  const MapQuality dirty = truth.judge(people, [&](std::size_t) { return now; });
  CHECK(dirty.ghost_share() > 0.9);  // feet are also on the floor
  CHECK(dirty.astray == 0);
  CHECK(dirty.coverage() < 0.1);
  const MapQuality late = truth.judge(people, [&](std::size_t) { return later; });
  CHECK(late.astray > late.ghosts);
  CHECK(std::isnan(truth.judge({}, [&](std::size_t) { return now; }).ghost_share()));
}

TEST_CASE("a sequence says which scene it shows") {
  const dynfilter_test::TemporaryFolder folder;
  CHECK_FALSE(read_scene_name(folder.path()));
  write_scene_name(folder.path(), {"walking_xyz", 7, {}});
  CHECK(read_scene_name(folder.path())->scene == "walking_xyz");
  CHECK(read_scene_name(folder.path())->seed == 7);
  dynfilter_test::write_text(folder.path() / "scene.txt", "# scene seed\nwalking_xyz many\n");
  CHECK_THROWS_AS(read_scene_name(folder.path()), IoError);
}

}  // namespace map_truth_test
