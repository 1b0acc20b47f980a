// SPDX-License-Identifier: MIT
#include <cstring>
#include <dynfilter/core/error.hpp>
#include <dynfilter/pipeline/builtin_filters.hpp>
#include <dynfilter/pipeline/compose.hpp>
#include <dynfilter/pipeline/frame_observer.hpp>
#include <dynfilter/pipeline/pipeline_yaml.hpp>
#include <dynfilter/recorder/recording.hpp>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "doctest/doctest.h"
#include "io/tum_folder.hpp"
#include "recorder/recorded_host.hpp"

namespace recording_test {

using namespace dynfilter;
using dynfilter_test::RecordedHost;
using dynfilter_test::SceneSensor;
using recorder::RecordedEvent;
using recorder::RecordingReader;
namespace fs = std::filesystem;

namespace {

fs::path preset(const std::string& name) {
  return std::string(DYNFILTER_SOURCE_DIR) + "/examples/pipelines/" + name + ".yaml";
}

/// A file of a test.
struct File {
  dynfilter_test::TemporaryFolder folder;
  fs::path path = folder.path() / "run.dfr";
  std::string name() const { return path.string(); }
};

std::vector<Verdict> record(const File& file, PipelineConfig config, SceneSensor sensor,
                            const RecordingParams& params = {}) {
  Pipeline pipeline(std::move(config));
  pipeline.set_observer(open_recording(file.name(), params));
  std::vector<Verdict> verdicts;
  RecordedHost(sensor).play(pipeline, [&](const Verdict& verdict) { verdicts.push_back(verdict); });
  return verdicts;
}

/// Feeds the recorded events to a pipeline. `use` gets the recorded verdict and the new one.
template <class Use>
void replay(RecordingReader& reader, Pipeline& pipeline, const Use& use) {
  std::vector<KeyframeView> keyframes;
  while (const std::optional<RecordedEvent> event = reader.next()) {
    event->repeat(pipeline);
    if (event->kind == RecordedEvent::Kind::Frame) {
      const Verdict& again = pipeline.process(event->frame.view(keyframes), event->point, event->limits);
      REQUIRE(event->verdict);
      use(*event->verdict, again);
    }
  }
}

template <class T>
bool same(Span<const T> a, Span<const T> b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}
bool same(const cv::Mat& a, const cv::Mat& b) {
  return a.size == b.size && (a.empty() || (a.type() == b.type() && cv::norm(a, b, cv::NORM_INF) == 0));
}
bool same(const Pose& a, const Pose& b) {
  return a.rotation == b.rotation && a.translation_m == b.translation_m;
}

void check_same(const FrameView& a, const FrameView& b) {
  CHECK(a.id == b.id);
  CHECK(a.timestamp_s == b.timestamp_s);
  CHECK(same(a.keypoints, b.keypoints));
  CHECK(same(a.keypoints_undistorted, b.keypoints_undistorted));
  CHECK(same(a.descriptors, b.descriptors));
  CHECK(same(a.depth_m, b.depth_m));
  CHECK(same(a.right_u_px, b.right_u_px));
  CHECK(same(a.grey, b.grey));
  CHECK(same(a.depth, b.depth));
  CHECK(a.depth_unit_m == b.depth_unit_m);
  CHECK(a.camera == b.camera);
  CHECK(same(a.T_world_camera, b.T_world_camera));
  CHECK(a.pose_provenance == b.pose_provenance);
  REQUIRE(a.motion_prior.has_value() == b.motion_prior.has_value());
  if (a.motion_prior) {
    CHECK(a.motion_prior->reference_frame_id == b.motion_prior->reference_frame_id);
    CHECK(same(a.motion_prior->T_current_reference, b.motion_prior->T_current_reference));
    CHECK(a.motion_prior->covariance == b.motion_prior->covariance);
    CHECK(a.motion_prior->has_translation == b.motion_prior->has_translation);
  }
  CHECK(same(a.map_point_ids, b.map_point_ids));
  CHECK(same(a.map_points_world_m, b.map_points_world_m));
  REQUIRE(a.covisible_keyframes.size() == b.covisible_keyframes.size());
  for (std::size_t k = 0; k < a.covisible_keyframes.size(); ++k) {
    const KeyframeView &ka = a.covisible_keyframes[k], &kb = b.covisible_keyframes[k];
    CHECK((ka.id == kb.id && same(ka.T_world_camera, kb.T_world_camera)));
    CHECK(same(ka.keypoints_undistorted, kb.keypoints_undistorted));
    CHECK((same(ka.depth_m, kb.depth_m) && same(ka.map_point_ids, kb.map_point_ids)));
  }
  REQUIRE(
      (a.matches.has_value() == b.matches.has_value() && a.mask && b.mask && a.detections && b.detections));
  if (a.matches) {
    CHECK(a.matches->reference_frame_id == b.matches->reference_frame_id);
    CHECK(same(a.matches->reference_index, b.matches->reference_index));
  }
  CHECK((a.mask->frame_id == b.mask->frame_id && same(a.mask->labels, b.mask->labels)));
  CHECK(a.detections->frame_id == b.detections->frame_id);
  REQUIRE((a.detections->detections.size() == 1 && b.detections->detections.size() == 1));
  const Detection &da = a.detections->detections[0], &db = b.detections->detections[0];
  CHECK((da.box == db.box && da.class_id == db.class_id && da.class_name == db.class_name));
  CHECK((da.score == db.score && da.track_id == db.track_id && same(da.mask, db.mask)));
}

void write_bytes(const File& file, const std::string& bytes) {
  dynfilter_test::write_text(file.path, bytes);
}

/// Reads a whole recording. The number of frames, or the message of the error.
std::size_t frames_in(const fs::path& path, std::string& error) {
  std::size_t frames = 0;
  try {
    RecordingReader reader(path);
    while (const auto event = reader.next()) frames += event->kind == RecordedEvent::Kind::Frame ? 1 : 0;
  } catch (const IoError& problem) {
    error = problem.what();
  }
  return frames;
}

void check_same_content(const fs::path& a, const fs::path& b) {
  RecordingReader reader_a(a), reader_b(b);
  std::vector<KeyframeView> of_a, of_b;
  while (const auto event = reader_a.next()) {
    const auto other = reader_b.next();
    REQUIRE((other && other->kind == event->kind));
    if (event->kind != RecordedEvent::Kind::Frame) continue;
    check_same(event->frame.view(of_a), other->frame.view(of_b));
    CHECK(!recorder::difference(*event->verdict, *other->verdict).any());
  }
  CHECK(!reader_b.next());
}

}  // namespace

TEST_CASE("a recorded pipeline replays bit for bit, with each sensor and all inputs") {
  for (const SceneSensor sensor : {SceneSensor::RgbD, SceneSensor::Stereo, SceneSensor::Mono})
    for (const char* name : {"dynfilter", "ds_slam", "rts_slam", "sg_slam", "dynaslam"}) {
      CAPTURE(name);
      const File file;
      const std::vector<Verdict> host =
          record(file, pipeline_from_file(preset(name), builtin_filters()), sensor);
      RecordingReader reader(file.path);
      CHECK(reader.calls() == host.size());
      CHECK(reader.notes().empty());
      CHECK(reader.pipeline().name == name);
      Pipeline pipeline(config_of(reader.pipeline(), builtin_filters()));
      std::size_t k = 0, judged = 0;
      replay(reader, pipeline, [&](const Verdict& recorded, const Verdict& again) {
        REQUIRE(k < host.size());
        CHECK(!recorder::difference(recorded, host[k]).any());
        CHECK(!recorder::difference(recorded, again).any());
        for (const Vote vote : again.decision) judged += vote != Vote::Unknown ? 1 : 0;
        ++k;
      });
      CHECK(k == host.size());
      CHECK(judged > 0);
    }
}

TEST_CASE("every member of a frame comes back as it was handed in") {
  for (const SceneSensor sensor : {SceneSensor::RgbD, SceneSensor::Stereo, SceneSensor::Mono}) {
    const File file;
    record(file, pipeline_from_text("pipeline: {name: nothing}", builtin_filters()), sensor);
    RecordingReader reader(file.path);
    const RecordedHost host(sensor);
    std::vector<KeyframeView> keyframes;
    std::size_t resets = 0, losses = 0, poses = 0;
    while (const auto event = reader.next()) {
      resets += event->kind == RecordedEvent::Kind::Reset ? 1 : 0;
      losses += event->kind == RecordedEvent::Kind::Lost ? 1 : 0;
      if (event->kind == RecordedEvent::Kind::Pose) {
        const HostTracking told = host.tracking(poses++), kept = event->tracking.view();
        CHECK(same(told.keypoints, kept.keypoints));
        CHECK(same(told.map_point_ids, kept.map_point_ids));
        CHECK((told.inliers == kept.inliers && told.outliers == kept.outliers));
      }
      if (event->kind != RecordedEvent::Kind::Frame) continue;
      CHECK(event->frame.images_left_out == 0);
      CHECK(event->limits.min_features ==
            (event->point == CallPoint::BeforePose ? RecordedHost::kMinFeatures : 0));
      check_same(event->frame.view(keyframes),
                 host.view(static_cast<std::size_t>(event->frame.id), event->point));
    }
    CHECK(resets == 1);
    CHECK(losses == 1);
    CHECK(poses == 7);
  }
}

TEST_CASE("images are written once a frame, and padded ones without their padding") {
  const File file;
  const RecordedHost host(SceneSensor::RgbD);
  {
    Pipeline pipeline(pipeline_from_text("pipeline: {name: nothing}", builtin_filters()));
    pipeline.set_observer(open_recording(file.name()));
    FrameView view = host.view(0, CallPoint::BeforePose);
    pipeline.before_pose(view);
    const auto once = fs::file_size(file.path);
    cv::Mat wide(view.grey.rows, view.grey.cols + 7, CV_8UC1, cv::Scalar(9));
    view.grey.copyTo(wide.colRange(0, view.grey.cols));
    view.grey = wide.colRange(0, view.grey.cols);
    pipeline.after_pose(view);
    pipeline.set_observer(nullptr);
    CHECK(fs::file_size(file.path) > once);
  }
  RecordingReader reader(file.path);
  const auto first = reader.next(), second = reader.next();
  REQUIRE((first && second));
  CHECK(same(first->frame.grey, second->frame.grey));
  CHECK(first->frame.grey.data == second->frame.grey.data);  // one record
}

TEST_CASE("parameters that code changed after reading the YAML are recorded") {
  const File file;
  PipelineConfig config = pipeline_from_file(preset("dynfilter"), builtin_filters());
  config.params.first_frame_suspects = FirstFrameSuspects::Reject;
  config.floor.min_features = 7;
  record(file, std::move(config), SceneSensor::Mono);
  const PipelineConfig again = config_of(RecordingReader(file.path).pipeline(), builtin_filters());
  CHECK(again.params.first_frame_suspects == FirstFrameSuspects::Reject);
  CHECK(again.floor.min_features == 7);
  CHECK(again.params.max_time_gap_s == PipelineParams().max_time_gap_s);
}

TEST_CASE("a pipeline that was made in code is recorded, and replayed by the name of another") {
  const File file;
  PipelineConfig config;
  config.name = "mine";
  record(file, std::move(config), SceneSensor::Mono);
  RecordingReader reader(file.path);
  CHECK_THROWS_WITH_AS(config_of(reader.pipeline(), builtin_filters()),
                       "the recorded pipeline `mine`: was made in code, without YAML: name another one",
                       ConfigError);
}

TEST_CASE("without images the arrays are all there, and the frame counts what it lacks") {
  const File file;
  RecordingParams params;
  params.images = false;
  record(file, pipeline_from_file(preset("none"), builtin_filters()), SceneSensor::RgbD, params);
  RecordingReader reader(file.path);
  REQUIRE(reader.notes().size() == 1);
  CHECK(reader.notes()[0] == "the images of 19 calls were left out when recording");
  const auto event = reader.next();
  CHECK(event->frame.grey.empty());
  CHECK(event->frame.images_left_out == 4);  // grey, depth, labels, one box
  CHECK(event->frame.keypoints.size() > 100);
}

TEST_CASE("images that come faster than they are written are left out, and all that tell it agree") {
  constexpr int kSide_px = 6000;  // two of them are more than may wait
  constexpr int kMostFrames = 30;
  const File file;
  std::size_t told = 0;
  {
    Pipeline pipeline(pipeline_from_text("pipeline: {name: nothing}", builtin_filters()));
    pipeline.set_observer(open_recording(file.name()));
    cv::Mat images[2];
    for (cv::Mat& image : images) {
      image.create(kSide_px, kSide_px, CV_8UC1);
      cv::randu(image, 0, 256);
    }
    for (int k = 0; k < kMostFrames && told == 0; ++k) {
      FrameView view;
      view.id = k, view.timestamp_s = 0.1 * k;
      view.grey = images[k % 2];
      for (const std::string& note : pipeline.before_pose(view).report.notes)
        told += note == "flight recorder: the images of this frame are left out, too many wait to be written"
                    ? 1
                    : 0;
    }
  }
  CHECK(told == 1);
  RecordingReader reader(file.path);
  REQUIRE(reader.notes().size() == 1);
  CHECK(reader.notes()[0] == "the images of 1 call were left out when recording");
  std::size_t left_out = 0, calls = 0;
  while (const auto event = reader.next()) left_out += event->frame.images_left_out, ++calls;
  CHECK(left_out == 1);
  CHECK(calls == reader.calls());
}

TEST_CASE("a full recording ends where a record is whole, and the verdict says so once") {
  const File file;
  RecordingParams params;
  params.max_mb = 1;
  PipelineConfig config = pipeline_from_file(preset("none"), builtin_filters());
  Pipeline pipeline(std::move(config));
  pipeline.set_observer(open_recording(file.name(), params));
  const RecordedHost host(SceneSensor::RgbD);
  std::size_t told = 0, calls = 0;
  for (int round = 0; round < 6; ++round)
    host.play(pipeline, [&](const Verdict& verdict) {
      ++calls;
      for (const std::string& note : verdict.report.notes)
        told += note == "flight recorder: " + file.name() + " is full with 1 MB and ends here" ? 1 : 0;
    });
  CHECK(told == 1);
  pipeline.set_observer(nullptr);
  CHECK(fs::file_size(file.path) <= 1'000'000);
  RecordingReader reader(file.path);
  CHECK(reader.calls() < calls);
  REQUIRE(!reader.notes().empty());
  CHECK(reader.notes()[0] == "the recording was full and ended before the program did");
  while (reader.next()) {
  }
}

TEST_CASE("a file that cannot be written is refused at once") {
  CHECK_THROWS_WITH_AS(open_recording("/nowhere/run.dfr"),
                       "/nowhere/run.dfr: the recording cannot be written: No such file or directory",
                       IoError);
  RecordingParams params;
  params.max_mb = 0;
  const File file;
  CHECK_THROWS_WITH_AS(open_recording(file.name(), params), doctest::Contains("at least 1 MB"), IoError);
}

TEST_CASE("cut off anywhere, the records before it are read and the loss is noted") {
  const File whole, part;
  record(whole, pipeline_from_file(preset("none"), builtin_filters()), SceneSensor::Mono);
  const std::string bytes = dynfilter_test::read_text(whole.path);
  std::string error;
  const std::size_t all = frames_in(whole.path, error);
  CHECK((all == 19 && error.empty()));
  std::size_t last = 0;
  for (std::size_t size = 0; size < bytes.size(); size += 1 + size / 97) {
    write_bytes(part, bytes.substr(0, size));
    error.clear();
    const std::size_t frames = frames_in(part.path, error);
    CAPTURE(size);
    if (!error.empty()) CHECK(frames == 0);  // not even the pipeline is whole
    CHECK(frames >= last);
    last = frames;
    if (error.empty()) CHECK(!RecordingReader(part.path).notes().empty());
  }
  CHECK(last >= all - 1);
}

TEST_CASE("flipped bits are found by a checksum or end the file, and never pass") {
  const File whole, part;
  record(whole, pipeline_from_file(preset("none"), builtin_filters()), SceneSensor::Mono);
  const std::string bytes = dynfilter_test::read_text(whole.path);
  std::size_t damaged = 0;
  for (std::size_t at = 0; at < bytes.size(); at += 1 + at / 31) {
    std::string flipped = bytes;
    flipped[at] = static_cast<char>(flipped[at] ^ (1 << (at % 8)));
    write_bytes(part, flipped);
    std::string error;
    frames_in(part.path, error);
    CAPTURE(at);
    if (at >= 12 && at < 16) continue;                             // reserved
    if (error.empty()) check_same_content(whole.path, part.path);  // LZ4 has several ways to say the same
    CHECK(error.find('\n') == std::string::npos);
    damaged += error.find("is damaged") != std::string::npos ? 1 : 0;
  }
  CHECK(damaged > 100);
}

TEST_CASE("another version, another file and a folder are refused with one line") {
  const File file;
  std::string error;
  write_bytes(file, std::string("dynfrec\n\x01\0\0\0\0\0\0\0", 16));
  frames_in(file.path, error);
  CHECK(error == file.name() + ": is a recording of format 1, and this dynfilter reads format 3");
  write_bytes(file, "%YAML:1.0\npipeline: {}\n");
  frames_in(file.path, error);
  CHECK(error == file.name() + ": is no recording of dynfilter");
  frames_in(file.folder.path(), error);
  CHECK(error == file.folder.path().string() + ": cannot be opened");
  write_bytes(file, std::string("dynfrec\n\x03\0\0\0\0\0\0\0", 16));
  frames_in(file.path, error);
  CHECK(error == file.name() + ": the recording ends before its first record");
}

}  // namespace recording_test
