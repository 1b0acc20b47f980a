// SPDX-License-Identifier: MIT
// Loads a plugin and runs a pipeline with it on a small exact scene with a mover:
//   try_filter PLUGIN.so PIPELINE.yaml
#include <cstdio>
#include <dynfilter/core/error.hpp>
#include <dynfilter/pipeline/builtin_filters.hpp>
#include <dynfilter/pipeline/pipeline.hpp>
#include <dynfilter/pipeline/pipeline_yaml.hpp>
#include <dynfilter/plugin/loader.hpp>
#include <dynfilter/testing/exact_scene_presets.hpp>

int main(int argc, char** argv) try {
  using namespace dynfilter;
  if (argc != 3) {
    std::fprintf(stderr, "usage: try_filter PLUGIN.so PIPELINE.yaml\n");
    return 2;
  }
  Registry registry = builtin_filters();
  load_plugin(argv[1], registry);
  Pipeline pipeline(pipeline_from_file(argv[2], registry));

  const testing::ExactScene scene = testing::preset(testing::Preset::NoMotion).with_detections();
  int found = 0, dynamic = 0, lost = 0, fixed = 0;
  for (int k = 0; k < 10; ++k) {
    const testing::ExactFrame frame = scene.frame(k);
    const Verdict& verdict = pipeline.before_pose(frame.view());
    if (k < 5) continue;
    for (std::size_t i = 0; i < frame.size(); ++i) {
      dynamic += frame.truth[i] == testing::Truth::Dynamic;
      found += frame.truth[i] == testing::Truth::Dynamic && !verdict.keep(i);
      fixed += frame.truth[i] == testing::Truth::Static;
      lost += frame.truth[i] == testing::Truth::Static && !verdict.keep(i);
    }
  }
  std::printf("%s: %d of %d dynamic features found, %d of %d static ones lost\n", pipeline.name().c_str(),
              found, dynamic, lost, fixed);
  return found > dynamic / 2 && lost < fixed / 20 ? 0 : 1;
} catch (const dynfilter::Error& error) {
  std::fprintf(stderr, "try_filter: %s\n", error.what());
  return 2;
}
