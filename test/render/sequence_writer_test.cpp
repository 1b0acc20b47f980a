// SPDX-License-Identifier: MIT
#include <dynfilter/detectors/detections.hpp>
#include <filesystem>
#include <fstream>

#include "doctest/doctest.h"
#include "io/sequence.hpp"
#include "render/calibration_error.hpp"
#include "render/sequence_writer.hpp"

namespace sequence_writer_test {

using namespace dynfilter;
using namespace dynfilter::render;
namespace fs = std::filesystem;

namespace {

/// A temporary folder, removed at the end.
struct Folder {
  fs::path path;
  explicit Folder(const std::string& name) : path(fs::temp_directory_path() / ("dynfilter_synth_" + name)) {
    fs::remove_all(path);
    fs::create_directories(path);
  }
  ~Folder() { fs::remove_all(path); }
};

SequenceOptions short_walk() {
  SequenceOptions options;
  options.frames = 3;
  options.scene = "walking_static";
  return options;
}

}  // namespace

TEST_CASE("what is written is read again as a TUM sequence with truth") {
  const Folder folder("round");
  int calls = 0, last = 0;
  write_sequence(short_walk(), folder.path / "walk", [&](int done, int total) {
    ++calls;
    last = done;
    CHECK(total == 3);
  });
  CHECK(calls == 3);
  CHECK(last == 3);

  const io::Sequence sequence = io::Sequence::open(folder.path / "walk");
  REQUIRE(sequence.size() == 3);
  CHECK(sequence.has_labels());
  CHECK(sequence.camera() == freiburg3_camera());
  SequenceRenderer renderer(short_walk());
  const RenderedFrame expected = renderer.frame(2);
  const io::SequenceFrame got = sequence.load(2);
  CHECK(got.timestamp_s == doctest::Approx(expected.timestamp_s).epsilon(1e-15));
  CHECK(cv::norm(got.colour, expected.colour, cv::NORM_INF) == 0);
  CHECK(cv::norm(got.depth, expected.depth, cv::NORM_INF) == 0);
  CHECK(cv::norm(sequence.load_truth(2), expected.truth.dynamic, cv::NORM_INF) == 0);
  CHECK(cv::norm(sequence.load_labels(2), expected.truth.labels, cv::NORM_INF) == 0);
  const auto poses = sequence.ground_truth();
  REQUIRE(poses.has_value());
  CHECK((poses->at(2).T_world_camera.t() - expected.T_world_camera.t()).norm() < 1e-3);

  const io::DetectionTrack track = io::read_detections(folder.path / "walk" / "detections.txt");
  const auto* detections = track.at(expected.timestamp_s);
  REQUIRE(detections != nullptr);
  REQUIRE(detections->size() == expected.detections->size());
  CHECK(detections->front().class_name == expected.detections->front().class_name);
  CHECK(detections->front().box.x == doctest::Approx(expected.detections->front().box.x).epsilon(0.01));
}

TEST_CASE("scene.txt tells what the sensor did, camera.yaml what users are told about it") {
  const Folder folder("sensor");
  SequenceOptions options = short_walk();
  options.rate_hz = 10;
  options.calibration_error = 1;
  options.exposure_ms = 4;
  const SensorValues values = write_sequence(options, folder.path / "walk");
  std::ifstream in(folder.path / "walk" / "scene.txt");
  std::string line, text;
  while (std::getline(in, line)) text += line + "\n";
  for (const std::string setting : {"hz 10\n", "exposure_ms 4\n", "calibration_error 1\n",
                                    "rolling_shutter_ms 0\n", "exposure_steps 0\n"})
    CHECK(text.find("\n" + setting) != std::string::npos);
  CHECK(values.front() == std::pair<std::string, double>("hz", 10));
  const std::optional<SceneName> name = read_scene_name(folder.path / "walk");
  REQUIRE(name.has_value());
  CHECK(name->scene == "walking_static");
  CHECK(name->seed == options.seed);
  const io::Sequence sequence = io::Sequence::open(folder.path / "walk");
  CHECK(sequence.camera() == with_calibration_error(freiburg3_camera(), 1, options.seed));
  CHECK(sequence.timestamp_s(2) - sequence.timestamp_s(0) == doctest::Approx(0.2).epsilon(1e-5));
}

TEST_CASE("a folder with something in it is only replaced when asked") {
  const Folder folder("full");
  std::ofstream(folder.path / "notes.txt") << "mine";
  SequenceOptions options = short_walk();
  options.frames = 1;
  CHECK_THROWS_WITH_AS(write_sequence(options, folder.path), doctest::Contains("not empty"), IoError);
  CHECK(fs::exists(folder.path / "notes.txt"));
  options.overwrite = true;
  write_sequence(options, folder.path);
  CHECK_FALSE(fs::exists(folder.path / "notes.txt"));
  CHECK(fs::exists(folder.path / "associations.txt"));
}

TEST_CASE("a sequence that is broken off leaves nothing behind") {
  const Folder folder("broken");
  struct Stop {};
  CHECK_THROWS_AS(write_sequence(short_walk(), folder.path / "walk", [](int, int) { throw Stop(); }), Stop);
  CHECK(fs::is_empty(folder.path));
  SequenceOptions options = short_walk();
  options.scene = "nowhere";
  CHECK_THROWS_AS(write_sequence(options, folder.path / "walk"), ConfigError);
  CHECK(fs::is_empty(folder.path));
}

}  // namespace sequence_writer_test
