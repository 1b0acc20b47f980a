// SPDX-License-Identifier: MIT
// In the steady state `before_pose` allocates nothing, with OpenCV on one thread.
#include <dynfilter/pipeline/builtin_filters.hpp>
#include <dynfilter/pipeline/pipeline.hpp>
#include <dynfilter/pipeline/pipeline_yaml.hpp>
#include <opencv2/core/utility.hpp>
#include <string>
#include <vector>

#include "allocation_count.hpp"
#include "doctest/doctest.h"
#include "recording.hpp"

using namespace dynfilter;
using dynfilter_test::AllocationCount;

namespace {

constexpr int kFrames = 5;

/// CTest then shows the whole test as skipped. Where the counter should work and does not, its own case
/// fails.
bool skipped() {
  if (AllocationCount::works()) return false;
  MESSAGE(
      "skipped: allocations cannot be counted with a sanitizer's allocator, or without the GNU C library");
  return true;
}

const steady::Recording& recording(steady::Camera camera) {
  static const steady::Recording rgbd(steady::Camera::Rgbd, "walking_xyz", kFrames),
      stereo(steady::Camera::Stereo, "walking_xyz", kFrames),
      mono(steady::Camera::Mono, "walking_xyz", kFrames);
  return camera == steady::Camera::Rgbd ? rgbd : camera == steady::Camera::Stereo ? stereo : mono;
}

struct Steady {
  std::size_t allocations = 0, rejected = 0, judged_by_last = 0;
};

/// Over one period of the recording, after buffers have grown for some.
Steady steady_state(PipelineConfig config, const steady::Recording& frames) {
  constexpr std::size_t kWarmUp = 4;  // periods
  Pipeline pipeline(std::move(config));
  std::size_t n = 0;
  for (; n < kWarmUp * frames.period(); ++n) pipeline.before_pose(frames.view(n));
  Steady result;
  const AllocationCount count;
  for (; n < (kWarmUp + 1) * frames.period(); ++n) {
    const Verdict& verdict = pipeline.before_pose(frames.view(n));
    result.rejected += verdict.report.rejected;
    if (!verdict.report.stages.empty()) result.judged_by_last += verdict.report.stages.back().judged;
  }
  result.allocations = count.calls();
  return result;
}

PipelineConfig with_stages(const std::string& stages) {
  return pipeline_from_text("%YAML:1.0\n---\npipeline:\n  before_pose:\n" + stages, builtin_filters());
}

}  // namespace

TEST_CASE("the counter counts, and only while it exists") {
  if (skipped()) return;
  std::vector<int> outside(1000);
  const AllocationCount count;
  CHECK(count.calls() == 0);
  { const std::vector<int> inside(1000); }
  const cv::Mat image(10, 10, CV_8UC1);
  CHECK(count.calls() >= 2);
  CHECK(count.bytes() >= 1000 * sizeof(int) + 100);
}

TEST_CASE("in the steady state presets allocate nothing, with depth, two cameras or one") {
  if (skipped()) return;
  cv::setNumThreads(1);
  for (const auto camera : {steady::Camera::Rgbd, steady::Camera::Stereo, steady::Camera::Mono}) {
    CAPTURE(to_string(camera));
    const steady::Recording& frames = recording(camera);
    for (const std::string name : {"dynfilter", "dynfilter_mono", "rts_slam"}) {
      CAPTURE(name);
      const Steady steady = steady_state(
          pipeline_from_file(DYNFILTER_SOURCE_DIR "/examples/pipelines/" + name + ".yaml", builtin_filters()),
          frames);
      CHECK(steady.allocations == 0);
      CHECK(steady.rejected > 0);
    }
  }
}

TEST_CASE("in the steady state no rejector allocates") {
  if (skipped()) return;
  cv::setNumThreads(1);
  const steady::Recording& frames = recording(steady::Camera::Rgbd);
  for (const std::string& name : builtin_filters().names()) {
    CAPTURE(name);
    // Some judge only what an earlier stage called dynamic, or the rest.
    for (const std::string before : {"", "    - any: [ epipolar, { semantic_box: { role: reject } } ]\n"}) {
      CAPTURE(before);
      const bool spreads = name == "dbscan";  // it takes a cluster's other features
      const Steady steady = steady_state(with_stages(before + "    - " + name + "\n"), frames);
      CHECK(steady.allocations == 0);
      CHECK((steady.judged_by_last > 0 || spreads));
    }
  }
}

TEST_CASE("in the steady state no combinator allocates") {
  if (skipped()) return;
  cv::setNumThreads(1);
  const steady::Recording& frames = recording(steady::Camera::Rgbd);
  for (const std::string stage :
       {"sequence: [ epipolar, trajectory_consistency ]", "any: [ epipolar, trajectory_consistency ]",
        "all: [ epipolar, trajectory_consistency ]", "not: epipolar", "strict: epipolar",
        "first_available: [ background_motion, epipolar ]",
        "by_region: { inside: epipolar, outside: trajectory_consistency }",
        "vote: { of: [ epipolar, trajectory_consistency, gms ], min_votes: 2 }",
        "object_vote: { of: epipolar }", "cluster_expand: { of: epipolar }", "depth_layers: { of: epipolar }",
        "temporal: { of: epipolar }",
        "gate: { if: semantic_mask, then: epipolar, else: trajectory_consistency }"}) {
    CAPTURE(stage);
    CHECK(steady_state(with_stages("    - " + stage + "\n"), frames).allocations == 0);
  }
}
