// SPDX-License-Identifier: MIT
// S + G + T (boxes, epipolar, trajectory) without features and flow.
// The goals for 1000 features are 0.5 ms with up to 30 % on movers and 1 ms with 50 %.
// The time must grow by at most n^1.1.
#include <benchmark/benchmark.h>

#include <dynfilter/pipeline/builtin_filters.hpp>
#include <dynfilter/pipeline/frame_observer.hpp>
#include <dynfilter/pipeline/pipeline_yaml.hpp>
#include <dynfilter/testing/exact_scene.hpp>
#include <filesystem>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace {

using namespace dynfilter;
using testing::ExactFrame;
using testing::ExactScene;
using testing::MovingBox;

/// Frames with about `size` features, `dynamic_percent` of them on two movers.
std::vector<ExactFrame> frames(int dynamic_percent, int size) {
  const int movers = size * dynamic_percent / 200;
  ExactScene scene;
  scene.points((1400 - 14 * dynamic_percent) * size / 1000)
      .horizon(8)
      .pixel_noise(0.3)
      .depth_noise(0.0014)
      .with_detections();
  scene.mover(MovingBox(movers).at({-0.5, 0, 2.2}).moving({0.03, 0, 0.01}));
  scene.mover(MovingBox(movers).at({0.6, 0.1, 2.6}).moving({-0.02, 0.01, 0.02}));
  std::vector<ExactFrame> result;
  for (int k = 0; k < 8; ++k) result.push_back(scene.frame(k));
  return result;
}

void preset(benchmark::State& state, const std::string& name) {
  Pipeline pipeline(pipeline_from_file(
      std::string(DYNFILTER_SOURCE_DIR) + "/examples/pipelines/" + name + ".yaml", builtin_filters()));
  const std::vector<ExactFrame> sequence =
      frames(static_cast<int>(state.range(0)), static_cast<int>(state.range(1)));
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

/// What the flight recorder costs the host's thread: a pipeline without stages, recorded.
/// range(0): with images of 640x480, grey and depth, which change from frame to frame.
void flight_recorder(benchmark::State& state) {
  const std::filesystem::path file = std::filesystem::temp_directory_path() / "pipeline_benchmark.dfr";
  const std::vector<ExactFrame> sequence = frames(30, 1000);
  std::vector<cv::Mat> grey, depth;
  for (std::size_t k = 0; k < sequence.size(); ++k) {
    cv::randu(grey.emplace_back(480, 640, CV_8UC1), 0, 256);
    cv::randu(depth.emplace_back(480, 640, CV_16UC1), 5000, 6000);
  }
  {
    Pipeline pipeline(pipeline_from_text("pipeline: { name: nothing }", builtin_filters()));
    pipeline.set_observer(open_recording(file.string()));
    std::size_t next = 0;
    for (auto _ : state) {
      FrameView view = sequence[next].view();
      if (state.range(0) != 0) view.grey = grey[next], view.depth = depth[next];
      benchmark::DoNotOptimize(pipeline.before_pose(view).report.rejected);
      next = (next + 1) % sequence.size();
    }
  }
  std::filesystem::remove(file);
}

}  // namespace

#define DYNFILTER_PRESET(name)                        \
  BENCHMARK_CAPTURE(preset, name, std::string(#name)) \
      ->Args({30, 1000})                              \
      ->Args({50, 1000})                              \
      ->Args({30, 500})                               \
      ->Args({30, 2000})                              \
      ->Unit(benchmark::kMillisecond)

DYNFILTER_PRESET(rts_slam);
DYNFILTER_PRESET(rts_slam_sg);
DYNFILTER_PRESET(rts_slam_published);
DYNFILTER_PRESET(dynfilter);
// As many as do not fill the recording.
BENCHMARK(flight_recorder)->Arg(0)->Arg(1)->Iterations(500)->Unit(benchmark::kMillisecond);

BENCHMARK_MAIN();
