// SPDX-License-Identifier: MIT
// What every preset decides on small exact scenes, feature by feature, as one number each. A change that is not
// meant to change verdicts must not change these. One that is meant to: run `test_pipeline -tc="*digest*"`, look at
// what differs, and write the new numbers into verdict_digests.txt. No images: their filters come from OpenCV,
// which decides by the processor.
#include <dynfilter/core/cpu.hpp>
#include <dynfilter/core/verdict.hpp>
#include <dynfilter/dynfilter.hpp>
#include <dynfilter/pipeline/builtin_filters.hpp>
#include <dynfilter/pipeline/pipeline.hpp>
#include <dynfilter/pipeline/pipeline_yaml.hpp>
#include <dynfilter/synth/exact_scene.hpp>
#include <dynfilter/synth/exact_scene_frame.hpp>
#include <dynfilter/synth/exact_scene_presets.hpp>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>

#include "doctest/doctest.h"
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

std::string digest_of(const fs::path& file, synth::Preset scene_preset) {
  Pipeline pipeline(pipeline_from_file(file.string(), builtin_filters()));
  const synth::ExactScene scene = synth::preset(scene_preset)
                                      .pixel_noise(0.3)
                                      .depth_noise(0.0014)
                                      .mismatches(0.03)
                                      .missing_depth(0.05)
                                      .with_poses()
                                      .with_detections()
                                      .with_descriptors()
                                      .with_map_points();
  Digest digest;
  for (int k = 0; k < 10; ++k) {
    const synth::ExactFrame frame = scene.frame(k);
    add(pipeline.before_pose(frame.view()), digest);
    add(pipeline.after_pose(frame.view()), digest);
    if (k % 4 == 0) add(pipeline.at_keyframe(frame.view()), digest);
  }
  return digest.text();
}

TEST_CASE("verdict digests of the presets are those on record") {
  bool recorded_here = false;
#ifdef DYNFILTER_X86
  recorded_here = detail::cpu_has_avx2();
#endif
  if (!recorded_here) {
    MESSAGE("skipped: recorded on a processor with AVX2");
    return;
  }
  const std::string folder = std::string(DYNFILTER_SOURCE_DIR) + "/examples/pipelines";
  std::ifstream record(std::string(DYNFILTER_SOURCE_DIR) + "/test/pipeline/verdict_digests.txt");
  std::map<std::string, std::string> recorded;
  for (std::string preset, scene, digest; record >> preset >> scene >> digest;)
    recorded[preset + " " + scene] = digest;
  std::size_t compared = 0;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().stem().string();
    if (entry.path().extension() != ".yaml" || name == "oracle") continue;
    for (const synth::Preset scene :
         {synth::Preset::General, synth::Preset::Majority, synth::Preset::Rigid}) {
      const std::string key = name + " " + to_string(scene);
      INFO(key, " ", digest_of(entry.path(), scene));
      CHECK(recorded[key] == digest_of(entry.path(), scene));
      ++compared;
    }
  }
  CHECK(compared == recorded.size());
}

}  // namespace verdict_digest_test
