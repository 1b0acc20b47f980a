// SPDX-License-Identifier: MIT
// Pipeline::prepare(): what it does beside the host's work must not change a verdict.
#include <algorithm>
#include <dynfilter/pipeline/builtin_filters.hpp>
#include <dynfilter/pipeline/pipeline.hpp>
#include <dynfilter/pipeline/pipeline_yaml.hpp>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "doctest/doctest.h"
#include "pipeline/whole_pixel_scene.hpp"
#include "support/digest.hpp"

namespace prepare_test {

using namespace dynfilter;
namespace fs = std::filesystem;

constexpr int kFrames = 8;

using Frames = std::vector<std::unique_ptr<whole_pixel_scene::Frame>>;
const Frames& frames() {
  static const Frames all = [] {
    Frames made;
    for (int k = 0; k < kFrames; ++k) made.push_back(std::make_unique<whole_pixel_scene::Frame>(k));
    return made;
  }();
  return all;
}

PipelineConfig preset(const std::string& name) {
  return pipeline_from_file(std::string(DYNFILTER_SOURCE_DIR) + "/examples/pipelines/" + name + ".yaml",
                            builtin_filters());
}

struct Played {
  std::string digest;
  int in_vain = 0;  ///< notes
};

/// `before(pipeline, k)` runs before frame k.
using Before = std::function<void(Pipeline&, int)>;
Played play(PipelineConfig config, const Before& before) {
  Pipeline pipeline(std::move(config));
  digest::Digest digest;
  Played played;
  for (int k = 0; k < kFrames; ++k) {
    before(pipeline, k);
    const FrameView& view = frames()[static_cast<std::size_t>(k)]->view();
    for (const CallPoint point : {CallPoint::BeforePose, CallPoint::AfterPose, CallPoint::AtKeyframe}) {
      const Verdict& verdict = pipeline.process(view, point);
      for (std::size_t i = 0; i < verdict.size(); ++i)
        digest.add(static_cast<std::uint64_t>(verdict.decision[i]) + 4 * verdict.prior[i] +
                   16 * verdict.reasons[i]);
      for (const float suspicion : verdict.suspicion)
        digest.add(static_cast<std::uint64_t>(1e6F * (1 + suspicion)));
      for (const std::string& note : verdict.report.notes)
        played.in_vain += note.rfind("prepare()", 0) == 0 ? 1 : 0;
    }
  }
  played.digest = digest.text();
  return played;
}

const FrameView& view_of(int k) {
  return frames()[static_cast<std::size_t>(k)]->view();
}

TEST_CASE("prepare() in a thread changes no verdict of any preset") {
  for (const auto& entry :
       fs::directory_iterator(std::string(DYNFILTER_SOURCE_DIR) + "/examples/pipelines")) {
    const std::string name = entry.path().stem().string();
    if (entry.path().extension() != ".yaml" || name == "oracle") continue;
    CAPTURE(name);
    const Played without = play(preset(name), [](Pipeline&, int) {});
    const Played with = play(preset(name), [](Pipeline& pipeline, int k) {
      cv::Mat copy = view_of(k).grey.clone();  // hosts hand in other memory with the same pixels
      std::thread([&] { pipeline.prepare(copy, view_of(k).timestamp_s); }).join();
    });
    CHECK(with.digest == without.digest);
    CHECK(with.in_vain == 0);
  }
}

TEST_CASE("every engine of flow, and frames that are prepared twice or now and then") {
  for (const char* engine : {"guided", "own", "opencv"}) {
    CAPTURE(engine);
    const std::string text = std::string("pipeline:\n  correspondence: { flow: { engine: ") + engine +
                             " } }\n  before_pose: [ epipolar, background_motion ]\n";
    const auto config = [&] { return pipeline_from_text(text, builtin_filters()); };
    const Played without = play(config(), [](Pipeline&, int) {});
    const Played twice = play(config(), [](Pipeline& pipeline, int k) {
      pipeline.prepare(view_of((k + 1) % kFrames).grey, 77);
      if (k % 3 != 1) pipeline.prepare(view_of(k).grey, view_of(k).timestamp_s);
    });
    CHECK(twice.digest == without.digest);
    CHECK(twice.in_vain == 3);  // frames 1, 4 and 7
  }
}

TEST_CASE("another image, another stamp and images that cannot be used are not used") {
  const Played without = play(preset("dynfilter"), [](Pipeline&, int) {});
  const auto check = [&](int in_vain, const Before& before) {
    const Played played = play(preset("dynfilter"), before);
    CHECK(played.digest == without.digest);
    CHECK(played.in_vain == in_vain);
  };
  check(kFrames, [](Pipeline& p, int k) { p.prepare(view_of(k).grey, view_of(k).timestamp_s + 1e-6); });
  check(kFrames, [](Pipeline& p, int k) {
    cv::Mat other = view_of(k).grey.clone();
    other.at<std::uint8_t>(other.rows - 1, other.cols - 1) ^= 1;
    p.prepare(other, view_of(k).timestamp_s);
  });
  check(kFrames, [](Pipeline& p, int k) {
    p.prepare(view_of(k).grey(cv::Rect(0, 0, 100, 90)), view_of(k).timestamp_s);
  });
  check(0, [](Pipeline& p, int k) { p.prepare(cv::Mat(), view_of(k).timestamp_s); });
  check(0, [](Pipeline& p, int k) { p.prepare(view_of(k).depth, view_of(k).timestamp_s); });
}

TEST_CASE("a reset forgets what was prepared") {
  Pipeline pipeline(preset("dynfilter"));
  pipeline.before_pose(view_of(0));
  pipeline.prepare(view_of(1).grey, view_of(1).timestamp_s);
  pipeline.reset();
  CHECK(pipeline.before_pose(view_of(1)).report.notes.empty());
}

}  // namespace prepare_test
