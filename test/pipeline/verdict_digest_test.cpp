// SPDX-License-Identifier: MIT
// What every preset decides on every exact scene and on images, feature by feature, as one number each. Every
// compiler, C library and processor must produce them: CTest runs this file also as on a processor of 2010
// (test/CMakeLists.txt), and test/run.sh with Clang. A change that is not meant to change verdicts must not
// change these. One that is meant to: run with DYNFILTER_UPDATE_DIGESTS=1, which writes verdict_digests.txt,
// and look at what differs.
#include <cstdlib>
#include <dynfilter/core/verdict.hpp>
#include <dynfilter/dynfilter.hpp>
#include <dynfilter/pipeline/builtin_filters.hpp>
#include <dynfilter/pipeline/pipeline.hpp>
#include <dynfilter/pipeline/pipeline_yaml.hpp>
#include <dynfilter/testing/exact_scene.hpp>
#include <dynfilter/testing/exact_scene_frame.hpp>
#include <dynfilter/testing/exact_scene_presets.hpp>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "doctest/doctest.h"
#include "pipeline/whole_pixel_scene.hpp"
#include "support/digest.hpp"

namespace verdict_digest_test {

using namespace dynfilter;
using digest::Digest;
namespace fs = std::filesystem;

void add(const Verdict& verdict, Digest& digest) {
  digest.add(verdict.size());
  for (std::size_t i = 0; i < verdict.size(); ++i)
    digest.add(static_cast<std::uint64_t>(verdict.decision[i]) + 4 * verdict.prior[i] +
               8 * verdict.restored[i] + 16 * verdict.reasons[i]);
}

constexpr int kFrames = 10;

/// `frame_of(k)` has a view().
template <class FrameOf>
std::string digest_of(const fs::path& file, FrameOf frame_of) {
  Pipeline pipeline(pipeline_from_file(file.string(), builtin_filters()));
  Digest digest;
  for (int k = 0; k < kFrames; ++k) {
    const auto& frame = frame_of(k);
    add(pipeline.before_pose(frame.view()), digest);
    add(pipeline.after_pose(frame.view()), digest);
    if (k % 4 == 0) add(pipeline.at_keyframe(frame.view()), digest);
  }
  return digest.text();
}

using Digests = std::map<std::string, std::string>;  ///< by "preset scene"

Digests computed() {
  std::map<std::string, std::vector<std::unique_ptr<whole_pixel_scene::Frame>>> images;
  for (int k = 0; k < kFrames; ++k) {
    images["images"].push_back(std::make_unique<whole_pixel_scene::Frame>(k));
    images["stereo"].push_back(std::make_unique<whole_pixel_scene::Frame>(k, true));
  }
  Digests digests;
  for (const auto& entry :
       fs::directory_iterator(std::string(DYNFILTER_SOURCE_DIR) + "/examples/pipelines")) {
    const std::string name = entry.path().stem().string();
    if (entry.path().extension() != ".yaml" || name == "oracle") continue;
    for (const testing::Preset preset : testing::all_presets()) {
      const testing::ExactScene scene = testing::preset(preset)
                                            .pixel_noise(0.3)
                                            .depth_noise(0.0014)
                                            .mismatches(0.03)
                                            .missing_depth(0.05)
                                            .with_poses()
                                            .with_detections()
                                            .with_descriptors()
                                            .with_map_points();
      digests[name + " " + to_string(preset)] =
          digest_of(entry.path(), [&](int k) { return scene.frame(k); });
    }
    for (const auto& [kind, frames] : images)
      digests[name + " " + kind] =
          digest_of(entry.path(), [&shown = frames](int k) -> const whole_pixel_scene::Frame& {
            return *shown[static_cast<std::size_t>(k)];
          });
  }
  return digests;
}

TEST_CASE("what the digests are of: with either camera the person is found, and the wall is kept") {
  for (const bool stereo : {false, true}) {
    CAPTURE(stereo);
    Pipeline pipeline(pipeline_from_file(
        std::string(DYNFILTER_SOURCE_DIR) + "/examples/pipelines/dynfilter.yaml", builtin_filters()));
    double person = 0, found = 0, wall = 0, lost = 0;
    for (int k = 0; k < kFrames; ++k) {
      const whole_pixel_scene::Frame frame(k, stereo);
      const Verdict& verdict = pipeline.before_pose(frame.view());
      if (k < 5) continue;  // the first choices reject nothing
      const cv::Rect2f box = frame.view().detections->detections[0].box;
      const cv::Rect2f inside(box.x + 8, box.y + 8, box.width - 16, box.height - 16);
      const cv::Rect2f around(box.x - 24, box.y - 24, box.width + 48, box.height + 48);
      for (std::size_t i = 0; i < verdict.size(); ++i) {
        const cv::Point2f px = frame.view().keypoints[i].pt;
        if (inside.contains(px)) ++person, found += verdict.keep(i) ? 0 : 1;
        if (!around.contains(px)) ++wall, lost += verdict.keep(i) ? 0 : 1;
      }
    }
    CHECK(found > 0.9 * person);
    CHECK(lost < 0.05 * wall);
  }
}

TEST_CASE("verdict digests of the presets are those on record") {
  const std::string file = std::string(DYNFILTER_SOURCE_DIR) + "/test/pipeline/verdict_digests.txt";
  const Digests digests = computed();
  if (std::getenv("DYNFILTER_UPDATE_DIGESTS") != nullptr) {
    std::ofstream out(file);
    for (const auto& [key, digest] : digests) out << key << " " << digest << "\n";
  }
  std::ifstream record(file);
  std::size_t recorded = 0;
  for (std::string preset, scene, digest; record >> preset >> scene >> digest; ++recorded) {
    const std::string key = preset + " " + scene;
    CAPTURE(key);
    REQUIRE(digests.count(key) == 1);
    CHECK(digests.at(key) == digest);
  }
  CHECK(recorded == digests.size());
}

}  // namespace verdict_digest_test
