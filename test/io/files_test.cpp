// SPDX-License-Identifier: MIT
#include <dynfilter/config/camera_file.hpp>
#include <dynfilter/detectors/detections.hpp>

#include "doctest/doctest.h"
#include "io/association.hpp"
#include "io/atomic_file.hpp"
#include "io/atomic_folder.hpp"
#include "io/camera_writer.hpp"
#include "io/known_camera.hpp"
#include "io/output_lock.hpp"
#include "io/ply.hpp"
#include "io/tum_folder.hpp"

namespace files_test {

using namespace dynfilter::io;
using namespace dynfilter_test;
using dynfilter::IoError;
namespace fs = std::filesystem;

namespace {

std::size_t entries(const fs::path& folder) {
  return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

}  // namespace

TEST_CASE("an atomic file: all or nothing") {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "a.txt";
  write_file_atomically(path, [](std::ostream& out) { out << "old"; });
  CHECK_THROWS_AS(write_file_atomically(path,
                                        [](std::ostream& out) {
                                          out << "ne";
                                          throw std::runtime_error("power cut");
                                        }),
                  std::runtime_error);
  CHECK(read_text(path) == "old");
  CHECK(entries(folder.path()) == 1);
  CHECK_THROWS_AS(write_file_atomically(folder.path() / "no" / "b.txt", [](std::ostream&) {}), IoError);
}

TEST_CASE(
    "an atomic folder appears whole, is removed when not committed, and spares what it does not replace") {
  const TemporaryFolder folder;
  const fs::path out = folder.path() / "out";
  { AtomicFolder abandoned(out); }
  CHECK(entries(folder.path()) == 0);
  for (const char* content : {"one", "two"}) {
    AtomicFolder results(out / "");
    fs::create_directories(results.path() / "sub");
    write_text(results.path() / "sub" / content, content);
    write_text(results.path() / "result", content);
    results.commit();
    CHECK(read_text(out / "result") == content);
    CHECK(entries(out / "sub") == 1);
    write_text(out / "mine", "keep me");
  }
  CHECK(read_text(out / "mine") == "keep me");
  CHECK(entries(folder.path()) == 1);
  CHECK_THROWS_AS(AtomicFolder(out / "result"), IoError);
  CHECK_THROWS_AS(AtomicFolder(folder.path() / "no" / "out"), IoError);
}

TEST_CASE("an atomic folder replaces another as a whole: other entries are kept or removed") {
  const TemporaryFolder folder;
  const fs::path out = folder.path() / "out";
  fs::create_directories(out / "notes" / "deep");
  write_text(out / "notes" / "deep" / "a.txt", "mine");
  write_text(out / "result", "old");
  fs::create_symlink("result", out / "link");
  fs::permissions(out, fs::perms::owner_all);
  const auto commit = [&](OtherEntries others) {
    AtomicFolder results(out, others);
    write_text(results.path() / "result", "new");
    CHECK(read_text(out / "result") == "old");
    results.commit();
    CHECK(read_text(out / "result") == "new");
    write_text(out / "result", "old");
    CHECK(fs::status(out).permissions() == fs::perms::owner_all);
  };
  commit(OtherEntries::Keep);
  CHECK(read_text(out / "notes" / "deep" / "a.txt") == "mine");
  CHECK(fs::is_symlink(out / "link"));
  commit(OtherEntries::Remove);
  CHECK(entries(out) == 1);
  CHECK(entries(folder.path()) == 1);
}

TEST_CASE("an atomic folder that cannot be renamed replaces entries: the working directory, a link to it") {
  const TemporaryFolder folder;
  const fs::path out = folder.path() / "out", before = fs::current_path();
  fs::create_directories(out);
  write_text(out / "mine", "keep");
  fs::create_directory_symlink("out", folder.path() / "link");
  fs::current_path(out);
  for (const fs::path& name : {fs::path("."), folder.path() / "link"}) {
    AtomicFolder results(name);
    write_text(results.path() / "result", name.string());
    results.commit();
    CHECK(read_text(out / "result") == name.string());
    CHECK(fs::exists("result"));  // the working directory is the folder as before
    CHECK(read_text("mine") == "keep");
  }
  fs::current_path(before);
  CHECK(entries(folder.path()) == 2);
}

TEST_CASE("one writer at a time, and what a killed one left is removed by the next") {
  const TemporaryFolder folder;
  const fs::path out = folder.path() / "out";
  {
    const AtomicFolder first(out);
    CHECK_THROWS_WITH_AS(AtomicFolder(out / ""), doctest::Contains("another program is writing here"),
                         IoError);
    CHECK_THROWS_AS(OutputLock{out}, IoError);
    CHECK_NOTHROW(OutputLock{folder.path() / "other"});
  }
  fs::create_directories(folder.path() / ".out.partial-0123abcd" / "overlay");
  write_text(folder.path() / ".out.lock", "");
  fs::create_directories(folder.path() / ".out.partial-mine");
  { const AtomicFolder second(out); }
  CHECK_FALSE(fs::exists(folder.path() / ".out.partial-0123abcd"));
  CHECK_FALSE(fs::exists(folder.path() / ".out.lock"));
  CHECK(fs::exists(folder.path() / ".out.partial-mine"));
}

TEST_CASE("association takes the closest pair of all first") {
  // Greedy by gap: 1.010-1.011 first, so 1.000 pairs with 0.985.
  // A greedy pass by time would pair 1.000 with 1.011.
  const auto pairs = associate({1.000, 1.010, 2.0}, {0.985, 1.011, 2.02}, 0.02);
  REQUIRE(pairs.size() == 2);
  CHECK(pairs[0] == std::pair<std::size_t, std::size_t>(0, 0));
  CHECK(pairs[1] == std::pair<std::size_t, std::size_t>(1, 1));
  CHECK(associate({}, {1.0}, 0.02).empty());
}

TEST_CASE("detections: names with blanks, seen-but-nothing, none came, unusable boxes counted") {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "d.txt";
  write_text(
      path,
      "# comment\n10.1 none\n10.0 0 person 0.9 10 20 30 60\n10.0 67 cell phone 0.5 1 2 3 4\n"
      "10.2 0 person 0.9 30 20 10 60\n10.2 0 person 1.9 10 20 30 60\n10.2 0 person 0.3 nan 20 30 60\n");
  const DetectionTrack track = read_detections(path);
  REQUIRE(track.at(10.0001));
  REQUIRE(track.at(10.0)->size() == 2);
  CHECK((*track.at(10.0))[0].box == cv::Rect2f(10, 20, 20, 40));
  CHECK((*track.at(10.0))[0].class_id == 0);
  CHECK((*track.at(10.0))[1].class_name == "cell phone");
  REQUIRE(track.at(10.1));
  CHECK(track.at(10.1)->empty());
  CHECK(track.at(10.05) == nullptr);
  CHECK(track.at(9) == nullptr);
  CHECK(track.at(11) == nullptr);
  CHECK(track.unusable == 3);
  write_text(path, "10 0 person 0.9 10 20 30\n");
  CHECK_THROWS_WITH_AS(read_detections(path), doctest::Contains("d.txt:1: expected"), IoError);
  write_text(path, "10 0 person 0.9 10 20 30 x\n");
  CHECK_THROWS_WITH_AS(read_detections(path), doctest::Contains("d.txt:1: 'x' is not a number"), IoError);
}

TEST_CASE("a camera file is read as written, and ORB-SLAM settings are understood") {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "camera.yaml";
  dynfilter::Camera camera = *known_camera("freiburg1");
  camera.baseline_fx_px_m = 40;
  write_camera(path, camera, 5000);
  CHECK(read_camera(path).camera == camera);
  CHECK(read_camera(path).depth_units_per_m == 5000);
  cv::FileStorage storage(path.string(), cv::FileStorage::READ);
  CHECK(storage["Camera.fx"].isReal());
  CHECK(static_cast<double>(storage["DepthMapFactor"]) == 5000);

  write_text(
      path,
      "%YAML:1.0\n---\nCamera.type: \"PinHole\"\nCamera1.fx: 500 # px\nCamera1.fy: 501.5\nCamera1.cx: 320\n"
      "Camera1.cy: 240\nCamera.RGB: 1\nORBextractor.nFeatures: 1000\nViewer.KeyFrameSize: 0.05\n");
  CHECK(read_camera(path).camera.fy_px == 501.5);
  CHECK_FALSE(read_camera(path).depth_units_per_m);
  write_text(path, "Camera.fx: 500\n");
  CHECK_THROWS_WITH_AS(read_camera(path), doctest::Contains("'Camera.fy' is missing"), IoError);
  write_text(path, "Camera.fx: wide\n");
  CHECK_THROWS_WITH_AS(read_camera(path), doctest::Contains("yaml:1: 'Camera.fx' is not a number"), IoError);
  write_text(path, "Camera.fx: -5\n");
  CHECK_THROWS_WITH_AS(read_camera(path), doctest::Contains("must be above 0"), IoError);
  write_text(path, "Camera.fx: 5\nCamera.fx: 6\n");
  CHECK_THROWS_WITH_AS(read_camera(path), doctest::Contains("given twice"), IoError);
  write_text(path, "Camera.type: \"KannalaBrandt8\"\n");
  CHECK_THROWS_WITH_AS(read_camera(path), doctest::Contains("only PinHole"), IoError);
}

TEST_CASE("known cameras by name, and no false friends") {
  CHECK(known_camera("rgbd_dataset_freiburg2_desk")->fx_px == 520.9);
  CHECK(known_camera("fr3_walk")->fx_px == 535.4);
  CHECK(known_camera("rgbd_bonn_crowd")->fx_px == 542.822841);
  CHECK_FALSE(known_camera("afr1"));
  CHECK_FALSE(known_camera("fr10"));
  CHECK_FALSE(known_camera("office"));
}

TEST_CASE("a PLY file has the header and the bytes of its points") {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "map.ply";
  write_ply(path, {{1, 2, 3}, {-1, 0, 0.5F}}, {{255, 0, 1}, {2, 3, 4}}, {7, -1});
  const std::string bytes = read_text(path);
  const std::string header_end = "end_header\n";
  const std::size_t body = bytes.find(header_end) + header_end.size();
  CHECK(bytes.rfind("ply\nformat binary_little_endian 1.0\nelement vertex 2\n", 0) == 0);
  REQUIRE(bytes.size() == body + 2 * (12 + 3 + 4));
  CHECK(bytes.substr(body, 4) == std::string("\x00\x00\x80\x3F", 4));       // 1.0f
  CHECK(bytes.substr(body + 12, 3) == std::string("\x01\x00\xFF", 3));      // red green blue
  CHECK(bytes.substr(body + 15, 4) == std::string("\x07\x00\x00\x00", 4));  // class
  CHECK_THROWS_AS(write_ply(path, {{1, 2, 3}}, {{1, 2, 3}, {1, 2, 3}}), IoError);
}

}  // namespace files_test
