// SPDX-License-Identifier: MIT
// The host's order of the features is no information: shuffled features get the same verdicts, feature by feature and to
// the last bit. No images, as for the digests.
#include <algorithm>
#include <cstdint>
#include <dynfilter/core/verdict.hpp>
#include <dynfilter/geometry/sampling.hpp>
#include <dynfilter/pipeline/builtin_filters.hpp>
#include <dynfilter/pipeline/pipeline.hpp>
#include <dynfilter/pipeline/pipeline_yaml.hpp>
#include <dynfilter/synth/exact_scene.hpp>
#include <dynfilter/synth/exact_scene_frame.hpp>
#include <dynfilter/synth/exact_scene_presets.hpp>
#include <filesystem>
#include <numeric>
#include <vector>

#include "doctest/doctest.h"

namespace feature_order_test {

using namespace dynfilter;
namespace fs = std::filesystem;

namespace {

/// Feature i of the frame becomes feature place[i] of the shuffled one.
using Places = std::vector<std::size_t>;

Places shuffled(std::size_t n, std::uint64_t seed) {
  Places place(n);
  std::iota(place.begin(), place.end(), std::size_t{0});
  Rng rng(seed);
  for (std::size_t i = n; i > 1; --i)
    std::swap(place[i - 1], place[rng.below(static_cast<std::uint32_t>(i))]);
  return place;
}

template <class T>
void move_to(const Places& place, std::vector<T>& values) {
  if (values.size() != place.size()) return;
  std::vector<T> moved(values.size());
  for (std::size_t i = 0; i < place.size(); ++i) moved[place[i]] = values[i];
  values = moved;
}

void shuffle(synth::ExactFrame& frame, const Places& place, const Places& last) {
  for (std::int32_t& reference : frame.reference_index)
    if (reference >= 0) reference = static_cast<std::int32_t>(last[static_cast<std::size_t>(reference)]);
  move_to(place, frame.keypoints);
  move_to(place, frame.keypoints_undistorted);
  move_to(place, frame.depth_m);
  move_to(place, frame.right_u_px);
  move_to(place, frame.reference_index);
  move_to(place, frame.map_point_ids);
  move_to(place, frame.map_points_world_m);
  const cv::Mat descriptors = frame.descriptors.clone();
  for (int i = 0; i < descriptors.rows; ++i)
    descriptors.row(i).copyTo(frame.descriptors.row(static_cast<int>(place[static_cast<std::size_t>(i)])));
}

std::size_t different(const Verdict& a, const Verdict& b, const Places& place) {
  std::size_t n = 0;
  for (std::size_t i = 0; i < place.size(); ++i) {
    const std::size_t j = place[i];
    n += a.decision[i] != b.decision[j] || a.suspicion[i] != b.suspicion[j] || a.prior[i] != b.prior[j] ||
                 a.restored[i] != b.restored[j] || a.reasons[i] != b.reasons[j]
             ? 1
             : 0;
  }
  return n;
}

synth::ExactScene scene_of(synth::Preset preset) {
  return synth::preset(preset)
      .pixel_noise(0.3)
      .depth_noise(0.0014)
      .mismatches(0.03)
      .missing_depth(0.05)
      .with_poses()
      .with_detections()
      .with_descriptors()
      .with_map_points();
}

std::size_t different_in(const fs::path& file, synth::Preset preset) {
  Pipeline straight(pipeline_from_file(file.string(), builtin_filters())),
      turned(pipeline_from_file(file.string(), builtin_filters()));
  const synth::ExactScene scene = scene_of(preset);
  std::size_t n = 0;
  Places last;
  for (int k = 0; k < 8; ++k) {
    const synth::ExactFrame frame = scene.frame(k);
    synth::ExactFrame other = scene.frame(k);
    const Places place = shuffled(frame.size(), static_cast<std::uint64_t>(k));
    if (frame.reference_frame_id >= 0) REQUIRE(frame.reference_frame_id == frame.id - 1);
    shuffle(other, place, last);
    for (const CallPoint point : {CallPoint::BeforePose, CallPoint::AfterPose, CallPoint::AtKeyframe})
      n += different(straight.process(frame.view(), point), turned.process(other.view(), point), place);
    last = place;
  }
  return n;
}

}  // namespace

TEST_CASE("shuffled features get the same verdicts, in every preset") {
  std::size_t compared = 0;
  for (const auto& entry :
       fs::directory_iterator(std::string(DYNFILTER_SOURCE_DIR) + "/examples/pipelines")) {
    if (entry.path().extension() != ".yaml" || entry.path().stem() == "oracle") continue;
    for (const synth::Preset preset : {synth::Preset::General, synth::Preset::Majority}) {
      INFO(entry.path().stem().string(), " ", synth::to_string(preset));
      CHECK(different_in(entry.path(), preset) == 0);
      ++compared;
    }
  }
  CHECK(compared > 20);
}

}  // namespace feature_order_test
