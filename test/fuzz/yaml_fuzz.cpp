// SPDX-License-Identifier: MIT
// YAML to a pipeline to three frames. Texts are refused with a ConfigError or give a pipeline that works.
#include <dynfilter/core/error.hpp>
#include <dynfilter/pipeline/builtin_filters.hpp>
#include <dynfilter/pipeline/pipeline.hpp>
#include <dynfilter/pipeline/pipeline_yaml.hpp>
#include <optional>

#include "bytes.hpp"
#include "frames.hpp"
#include "target.hpp"

namespace {

using namespace dynfilter;

/// Frames in which every input is there and sound.
std::vector<fuzz::OwnedFrame> sound_frames() {
  const std::uint8_t usual[] = {24, 4, 4, 0x40, 0, 6, 1, 0};
  fuzz::Bytes in(usual, sizeof(usual));
  fuzz::Frames frames(in);
  std::vector<fuzz::OwnedFrame> made;
  for (int k = 0; k < 3; ++k) {
    made.push_back(frames.next());
    made.back().has_boxes = made.back().has_mask = true;
  }
  return made;
}

std::optional<PipelineConfig> read(const std::string& text) {
  static const Registry registry = builtin_filters();
  try {
    return pipeline_from_text(text, registry);
  } catch (const ConfigError& error) {
    fuzz::require_one_line(error.what());
    return std::nullopt;
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static std::vector<fuzz::OwnedFrame> frames = sound_frames();
  auto config = read(std::string(reinterpret_cast<const char*>(data), size));
  if (!config) return 0;
  std::optional<Pipeline> pipeline;
  try {
    pipeline.emplace(std::move(*config));
  } catch (const ConfigError& error) {
    fuzz::require_one_line(error.what());
    return 0;
  }
  for (fuzz::OwnedFrame& frame : frames)
    for (const CallPoint point : {CallPoint::BeforePose, CallPoint::AfterPose, CallPoint::AtKeyframe}) {
      const Verdict& verdict = pipeline->process(frame.view(), point);
      fuzz::require(verdict.size() == frame.size(), "a verdict has an entry per feature");
      for (const StageReport& stage : verdict.report.stages)
        if (stage.failed) fuzz::fail("no stage throws", stage.path + ": " + stage.note);
    }
  return 0;
}
