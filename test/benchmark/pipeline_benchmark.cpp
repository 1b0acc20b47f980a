// SPDX-License-Identifier: MIT
// All of S + G + T (boxes, epipolar, trajectory) besides features and flow: the goal is 1 ms for 1000
// features.
#include <benchmark/benchmark.h>

#include <dynfilter/filters/builtin.hpp>
#include <dynfilter/pipeline/yaml.hpp>
#include <dynfilter/synth/exact_scene.hpp>
#include <string>
#include <vector>

namespace {

using namespace dynfilter;
using synth::ExactFrame;
using synth::ExactScene;
using synth::MovingBox;

/// About 1000 features a frame, of which so many percent lie on two movers.
std::vector<ExactFrame> frames(int dynamic_percent) {
  const int movers = 10 * dynamic_percent / 2;
  ExactScene scene;
  scene.points(1400 - 14 * dynamic_percent).horizon(8).pixel_noise(0.3).depth_noise(0.0014).with_detections();
  scene.mover(MovingBox(movers).at({-0.5, 0, 2.2}).moving({0.03, 0, 0.01}));
  scene.mover(MovingBox(movers).at({0.6, 0.1, 2.6}).moving({-0.02, 0.01, 0.02}));
  std::vector<ExactFrame> result;
  for (int k = 0; k < 8; ++k) result.push_back(scene.frame(k));
  return result;
}

void preset(benchmark::State& state, const std::string& name) {
  Pipeline pipeline(pipeline_from_file(
      std::string(DYNFILTER_SOURCE_DIR) + "/examples/pipelines/" + name + ".yaml", builtin_filters()));
  const std::vector<ExactFrame> sequence = frames(static_cast<int>(state.range(0)));
  std::size_t next = 0, features = 0, calls = 0;
  for (auto _ : state) {
    if (next == 0) pipeline.reset();
    benchmark::DoNotOptimize(pipeline.before_pose(sequence[next].view()).report.rejected);
    features += sequence[next].size();
    ++calls;
    next = (next + 1) % sequence.size();
  }
  state.counters["features"] = static_cast<double>(features) / static_cast<double>(calls);
}

}  // namespace

BENCHMARK_CAPTURE(preset, rts_slam, std::string("rts_slam"))->Arg(30)->Arg(50)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(preset, rts_slam_sg, std::string("rts_slam_sg"))
    ->Arg(30)
    ->Arg(50)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(preset, rts_slam_published, std::string("rts_slam_published"))
    ->Arg(30)
    ->Arg(50)
    ->Unit(benchmark::kMillisecond);

BENCHMARK_MAIN();
