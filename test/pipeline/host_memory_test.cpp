// SPDX-License-Identifier: MIT
// A host may free or overwrite all memory of a frame after the call. Every preset and every filter judges the
// same stream three times. The first memory stays as it is. The second is filled with zeros and freed after
// each call. The third are cv::Mats that the host fills with ones and uses again. The verdicts must be equal,
// bit for bit.
#include <dynfilter/core/votes.hpp>
#include <dynfilter/pipeline/builtin_filters.hpp>
#include <dynfilter/pipeline/pipeline.hpp>
#include <dynfilter/pipeline/pipeline_yaml.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "doctest/doctest.h"
#include "fuzz/frames.hpp"
#include "fuzz/lent_memory.hpp"

namespace host_memory_test {

using namespace dynfilter;

namespace {

/// Bits of the generator's inputs (fuzz/frames.hpp): with the bit, the input is missing.
enum Missing : std::uint16_t {
  kMatches = 1U << 0U,
  kBaseline = 1U << 3U,
  kGrey = 1U << 7U,
  kDepth = 1U << 8U,
  kFeatureDepth = 1U << 9U,
  kRight = 1U << 10U,
  kDescriptors = 1U << 11U,
};
constexpr unsigned kEstimatedPose = 2U << 5U;

struct Stream {
  const char* name;
  unsigned missing;
  bool hand_depth_over = false;
  bool mask_image = true;  ///< false: only the boxes' instance masks
};
const Stream kStreams[] = {
    {"RGB-D", kMatches | kRight},
    {"RGB-D, instance masks", kMatches | kRight, false, false},
    {"RGB-D, depth handed over, pose", kMatches | kRight | kEstimatedPose, true},
    {"stereo", kMatches | kDepth | kFeatureDepth},
    {"mono", kMatches | kBaseline | kDepth | kFeatureDepth | kRight},
    {"mono, instance masks", kMatches | kBaseline | kDepth | kFeatureDepth | kRight, false, false},
    {"host's matches", kGrey | kRight},
    {"descriptors", kMatches | kGrey | kDepth | kBaseline},
};

/// A result of the detector, which comes 1, 2 and 3 frames late, in new buffers each time. Some frames have
/// none.
constexpr int kLateFrames = 3, kFrames = 14;

std::vector<fuzz::OwnedFrame> frames_of(const Stream& stream) {
  constexpr std::uint8_t kBoxes = 1, kMask = 2;
  std::vector<std::uint8_t> bytes{48,
                                  12,
                                  9,
                                  static_cast<std::uint8_t>(stream.missing & 0xffU),
                                  static_cast<std::uint8_t>(stream.missing >> 8U),
                                  5,
                                  7,
                                  0};
  const auto semantics = static_cast<std::uint8_t>(kBoxes | (stream.mask_image ? kMask : 0));
  for (int k = 0; k < kFrames; ++k) bytes.insert(bytes.end(), {semantics, 0});
  fuzz::Bytes in(bytes.data(), bytes.size());
  fuzz::Frames generator(in);
  std::vector<fuzz::OwnedFrame> frames;
  for (int k = 0; k < kFrames; ++k) frames.push_back(generator.next());
  for (int k = kFrames - 1; k > kLateFrames; --k) {
    fuzz::OwnedFrame& frame = frames[static_cast<std::size_t>(k)];
    const int from = (k - 1) / kLateFrames * kLateFrames;
    frame.boxes = frames[static_cast<std::size_t>(from)].boxes;
    frame.labels = frames[static_cast<std::size_t>(from)].labels;
    frame.boxes_id = frame.mask_id = from;
    if (k % 5 == 0) frame.has_boxes = frame.has_mask = false;
  }
  for (fuzz::OwnedFrame& frame : frames) frame.depth_handed_over = stream.hand_depth_over;
  return frames;
}

/// All that a verdict says, but for times.
std::string text_of(const Verdict& verdict) {
  std::string text;
  const auto add = [&text](const auto& value) {
    text.append(reinterpret_cast<const char*>(&value), sizeof value);
  };
  for (std::size_t i = 0; i < verdict.size(); ++i)
    add(verdict.decision[i]), add(verdict.suspicion[i]), add(verdict.prior[i]), add(verdict.restored[i]),
        add(verdict.reasons[i]);
  for (const MapPointVerdict& point : verdict.map_points)
    add(point.map_point_id), add(point.vote), add(point.suspicion);
  for (const std::string& note : verdict.report.notes) text += note + "\n";
  for (const StageReport& stage : verdict.report.stages) {
    text += stage.name + " " + stage.note + "\n";
    add(stage.skipped), add(stage.failed), add(stage.judged), add(stage.dynamic), add(stage.prior);
  }
  return text;
}

struct Difference {
  std::string where;  ///< the first frame that differs; "" if none
  std::size_t retained = 0, late = 0, dynamic_late = 0;
};

/// `make` gives the same pipeline at each call.
template <class Make>
Difference compare(const Make& make, std::vector<fuzz::OwnedFrame> frames) {
  Pipeline stays(make()), freed(make()), reused(make());
  std::vector<std::unique_ptr<fuzz::LentFrame>> overwritten;
  Difference difference;
  for (fuzz::OwnedFrame& frame : frames)
    for (const CallPoint point : {CallPoint::BeforePose, CallPoint::AfterPose, CallPoint::AtKeyframe}) {
      if (point == CallPoint::AtKeyframe && frame.id % 4 != 0) continue;
      const Verdict& verdict = stays.process(frame.view(), point);
      const std::string expected = text_of(verdict);
      if (frame.boxes_id >= 0) {
        difference.late += expected.find("frames late") != std::string::npos ? 1 : 0;
        difference.dynamic_late += verdict.report.rejected + verdict.report.restored;
      }
      fuzz::LentFrame to_free(frame.view(), fuzz::Host::Frees, 0x00);
      const std::string after_free = text_of(freed.process(to_free.view(), point));
      to_free.take_back();
      overwritten.push_back(std::make_unique<fuzz::LentFrame>(frame.view(), fuzz::Host::Reuses, 0xff));
      const std::string after_reuse = text_of(reused.process(overwritten.back()->view(), point));
      difference.retained += overwritten.back()->take_back();
      if (difference.where.empty() && (after_free != expected || after_reuse != expected))
        difference.where = std::string(after_free != expected ? "freed" : "reused") + " memory, frame " +
                           std::to_string(frame.id) + ", " + to_string(point);
    }
  return difference;
}

template <class Make>
Difference check_streams(const Make& make) {
  Difference all;
  for (const Stream& stream : kStreams) {
    CAPTURE(std::string(stream.name));
    const Difference difference = compare(make, frames_of(stream));
    CHECK(difference.where == "");
    CHECK(difference.retained == 0);
    all.late += difference.late, all.dynamic_late += difference.dynamic_late;
  }
  return all;
}

std::vector<std::filesystem::path> pipeline_files() {
  std::vector<std::filesystem::path> files;
  for (const char* folder : {"/examples/pipelines", "/examples/combinators", "/test/fuzz/pipelines"})
    for (const auto& entry : std::filesystem::directory_iterator(std::string(DYNFILTER_SOURCE_DIR) + folder))
      if (entry.path().stem() != "oracle") files.push_back(entry.path());  // needs labels
  std::sort(files.begin(), files.end());
  return files;
}

PipelineConfig with_stage(const std::string& stage) {
  return pipeline_from_text("%YAML:1.0\n---\npipeline:\n  before_pose:\n    - " + stage + "\n",
                            builtin_filters());
}

}  // namespace

TEST_CASE("every preset: the host frees or overwrites the frame's memory after the call") {
  for (const std::filesystem::path& file : pipeline_files()) {
    CAPTURE(file.stem().string());
    check_streams([&] { return pipeline_from_file(file.string(), builtin_filters()); });
  }
}

TEST_CASE("every filter: the host frees or overwrites the frame's memory after the call") {
  for (const std::string& name : builtin_filters().names()) {
    CAPTURE(name);
    check_streams([&] { return with_stage(name); });
  }
}

TEST_CASE("late boxes and masks: the host frees or overwrites them after the call") {
  for (const char* stage :
       {"{ semantic_box: { role: reject, refine: depth } }", "{ semantic_mask: { role: reject } }",
        "{ semantic_mask: { source: instances, role: reject } }",
        "{ object_vote: { of: { semantic_mask: { source: instances, role: reject } }, objects: instances } }",
        "{ cluster_expand: { of: { semantic_box: { role: reject } }, space: image, radius_px: 6 } }"}) {
    CAPTURE(std::string(stage));
    const Difference all = check_streams([&] { return with_stage(stage); });
    CHECK(all.late > 0);  // the case is in the stream
    CHECK(all.dynamic_late > 0);
  }
}

}  // namespace host_memory_test
