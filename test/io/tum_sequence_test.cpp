// SPDX-License-Identifier: MIT
#include <dynfilter/config/camera_file.hpp>

#include "doctest/doctest.h"
#include "io/known_camera.hpp"
#include "io/sequence.hpp"
#include "io/tum_folder.hpp"

namespace tum_sequence_test {

using dynfilter::IoError;
using dynfilter::io::Sequence;
using dynfilter::io::SequenceOptions;
using namespace dynfilter_test;
namespace fs = std::filesystem;

namespace {

// The error of open() or of load() of any frame; "" without an error.
std::string complaint(const fs::path& folder, const SequenceOptions& options = {}) {
  try {
    const Sequence sequence = Sequence::open(folder, options);
    for (std::size_t i = 0; i < sequence.size(); ++i) sequence.load(i);
    return "";
  } catch (const IoError& error) {
    CHECK(std::string(error.what()).find('\n') == std::string::npos);
    return error.what();
  }
}

bool has(const std::string& text, const std::string& part) {
  CAPTURE(text);
  CHECK(text.find(part) != std::string::npos);
  return text.find(part) != std::string::npos;
}

void cut_in_half(const fs::path& file) {
  fs::resize_file(file, fs::file_size(file) / 2);
}

}  // namespace

TEST_CASE("a folder without associations.txt: every colour image, with the closest depth") {
  const TemporaryFolder folder;
  write_tum_folder(folder.path(), 4);
  const Sequence sequence = Sequence::open(folder.path());
  REQUIRE(sequence.size() == 4);
  CHECK(sequence.timestamp_s(2) == doctest::Approx(100.2).epsilon(1e-12));
  CHECK(sequence.camera().fx_px == 20);
  CHECK(sequence.notes().empty());
  CHECK_FALSE(sequence.has_labels());
  CHECK_FALSE(sequence.ground_truth());
  const auto frame = sequence.load(2);
  CHECK(frame.colour.type() == CV_8UC3);
  CHECK(frame.grey.type() == CV_8UC1);
  CHECK(frame.colour.at<cv::Vec3b>(5, 5) == cv::Vec3b(10, 20, 2));
  CHECK(frame.depth.at<std::uint16_t>(5, 5) == 5002);
  CHECK(frame.depth.at<std::uint16_t>(5, 5) * frame.depth_unit_m == doctest::Approx(1.0004));
}

TEST_CASE("associations.txt decides where it is there, in either column order") {
  const TemporaryFolder folder;
  write_tum_folder(folder.path(), 4);
  const std::string colour = "100.100000 rgb/100.100000.png", depth = "100.103000 depth/100.103000.png";
  for (const std::string& line : {colour + " " + depth, depth + "\t" + colour, colour + "," + depth + "\r"}) {
    write_text(folder.path() / "associations.txt", line + "\n");
    const Sequence sequence = Sequence::open(folder.path());
    REQUIRE(sequence.size() == 1);
    REQUIRE(sequence.notes().size() == 1);
    has(sequence.notes()[0], "3 images of rgb.txt not in it");
    CHECK(sequence.timestamp_s(0) == doctest::Approx(100.1).epsilon(1e-12));
    CHECK(sequence.load(0).depth.at<std::uint16_t>(0, 0) == 5001);
  }
}

TEST_CASE("a frame without depth is kept, counted and reported once") {
  const TemporaryFolder folder;
  write_tum_folder(folder.path(), 4);
  fs::remove(folder.path() / "depth" / "100.203000.png");
  const Sequence sequence = Sequence::open(folder.path());
  CHECK(sequence.size() == 4);
  CHECK(sequence.load(2).depth.empty());
  CHECK_FALSE(sequence.load(1).depth.empty());
  REQUIRE(sequence.notes().size() == 2);
  has(sequence.notes()[0], "depth.txt: 1 missing image left out");
  has(sequence.notes()[1], "1 frame has no depth image");
}

TEST_CASE("bad folders: one line that names the culprit") {
  const TemporaryFolder root;
  const fs::path folder = root.path() / "sequence";
  has(complaint(folder), "sequence: no such folder");
  write_tum_folder(folder, 3);
  REQUIRE(complaint(folder) == "");
  SUBCASE("empty rgb.txt") {
    write_text(folder / "rgb.txt", "# nothing\n");
    has(complaint(folder), "rgb.txt: lists no images");
  }
  SUBCASE("no depth.txt") {
    fs::remove(folder / "depth.txt");
    has(complaint(folder), "depth.txt: no such file");
  }
  SUBCASE("stamps out of order") {
    write_text(folder / "rgb.txt", "100.1 rgb/100.100000.png\n100.0 rgb/100.000000.png\n");
    has(complaint(folder), "rgb.txt:2: timestamps out of order");
  }
  SUBCASE("depth stamps out of order") {
    write_text(folder / "depth.txt", "100.1 depth/100.103000.png\n100.0 depth/100.003000.png\n");
    has(complaint(folder), "depth.txt:2: timestamps out of order");
  }
  SUBCASE("association stamps out of order") {
    write_text(folder / "associations.txt",
               "100.1 rgb/100.100000.png 100.103 depth/100.103000.png\n100 rgb/100.000000.png 100 "
               "depth/100.003000.png\n");
    has(complaint(folder), "associations.txt:2: timestamps out of order");
  }
  SUBCASE("no association within tolerance") {
    SequenceOptions options;
    options.max_association_gap_s = 0.002;
    has(complaint(folder, options), "no depth image within 0.002 s of a colour image");
  }
  SUBCASE("no image that is listed is there") {
    fs::remove_all(folder / "rgb");
    has(complaint(folder), "rgb.txt: none of the listed images exists");
  }
  SUBCASE("a stamp that is no number") {
    write_text(folder / "rgb.txt", "100.0x rgb/100.000000.png\n");
    has(complaint(folder), "rgb.txt:1: '100.0x' is not a timestamp");
  }
  SUBCASE("a line too short") {
    write_text(folder / "rgb.txt", "100.0\n");
    has(complaint(folder), "rgb.txt:1: expected");
  }
}

TEST_CASE("bad images: one line that names the file") {
  const TemporaryFolder root;
  const fs::path& folder = root.path();
  write_tum_folder(folder, 3);
  const fs::path colour = folder / "rgb" / "100.100000.png", depth = folder / "depth" / "100.103000.png";
  SUBCASE("truncated colour") {
    cut_in_half(colour);
    has(complaint(folder), "100.100000.png: is truncated");
  }
  SUBCASE("only the end chunk is missing: OpenCV would decode it") {
    fs::resize_file(depth, fs::file_size(depth) - 12);
    has(complaint(folder), "100.103000.png: is truncated");
  }
  SUBCASE("empty") {
    write_text(depth, "");
    has(complaint(folder), "100.103000.png: is empty");
  }
  SUBCASE("not a picture") {
    write_text(colour, "not a picture at all");
    has(complaint(folder), "100.100000.png: is not a PNG, JPEG, BMP or binary PGM or PPM image");
  }
  SUBCASE("a flipped bit") {
    std::string bytes = read_text(colour);
    bytes[bytes.size() - 20] = static_cast<char>(bytes[bytes.size() - 20] ^ 4);
    write_text(colour, bytes);
    has(complaint(folder), "100.100000.png: is damaged");
  }
  SUBCASE("depth of another size") {
    cv::imwrite(depth.string(), cv::Mat(6, 8, CV_16UC1, cv::Scalar(5000)));
    has(complaint(folder), "100.103000.png: is 8x6, but its colour image rgb/100.100000.png is 16x12");
  }
  SUBCASE("depth of 8 bit") {
    cv::imwrite(depth.string(), cv::Mat(12, 16, CV_8UC1, cv::Scalar(50)));
    has(complaint(folder), "is not a 16-bit depth image");
  }
  SUBCASE("another size than the camera's") {
    SequenceOptions options;
    options.camera = dynfilter::io::known_camera("freiburg3");
    has(complaint(folder, options), "is 16x12, but the camera is for 640x480");
  }
}

TEST_CASE("the camera: option before file before name before recording; else an error") {
  const TemporaryFolder root;
  const fs::path& folder = root.path();
  write_tum_folder(folder, 1);
  SequenceOptions options;
  options.camera = dynfilter::io::known_camera("rgbd_bonn_crowd");
  REQUIRE(options.camera);
  CHECK(Sequence::open(folder, options).camera().fx_px == 542.822841);
  CHECK(Sequence::open(folder).camera().fx_px == 20);
  fs::remove(folder / "camera.yaml");
  CHECK(Sequence::open(folder).camera().fx_px == 535.4);  // the comment in rgb.txt
  fs::create_directories(folder / "tum_fr1_xyz");
  write_tum_folder(folder / "tum_fr1_xyz", 1);
  fs::remove(folder / "tum_fr1_xyz" / "camera.yaml");
  CHECK(Sequence::open(folder / "tum_fr1_xyz" / "").camera().fx_px == 517.3);
  write_text(folder / "rgb.txt", "100.0 rgb/100.000000.png\n");
  has(complaint(folder), "the camera is not known");
}

TEST_CASE("labels of a synthetic folder are read as they were written") {
  const TemporaryFolder root;
  const fs::path& folder = root.path();
  write_tum_folder(folder, 1);
  for (const char* kind : {"labels", "dynamic"}) fs::create_directories(folder / kind);
  cv::imwrite((folder / "labels" / "100.000000.png").string(), cv::Mat(12, 16, CV_8UC1, cv::Scalar(3)));
  cv::imwrite((folder / "dynamic" / "100.000000.png").string(), cv::Mat(12, 16, CV_8UC1, cv::Scalar(128)));
  const Sequence sequence = Sequence::open(folder);
  CHECK(sequence.has_labels());
  CHECK(sequence.load_labels(0).at<std::uint8_t>(3, 4) == 3);
  CHECK(sequence.load_truth(0).at<std::uint8_t>(3, 4) == 128);
  fs::remove(folder / "dynamic" / "100.000000.png");
  CHECK_THROWS_AS(sequence.load_truth(0), IoError);
}

TEST_CASE("the real TUM folders load as downloaded" * doctest::test_suite("shared_data")) {
  const fs::path data = DYNFILTER_DATA_DIR;
  if (!fs::exists(data)) {
    MESSAGE("skipped: no ../shared/data");
    return;
  }
  const Sequence walking = Sequence::open(data / "tum_fr3_walking_halfsphere");
  // One of the 50 images has no depth, so associations.txt does not list it.
  CHECK(walking.size() == 49);
  REQUIRE(walking.notes().size() == 1);
  CHECK(walking.notes()[0] == "associations.txt: 1 image of rgb.txt not in it, left out");
  CHECK(walking.camera().fx_px == 535.4);
  CHECK(walking.load(0).depth.size() == cv::Size(640, 480));
  CHECK(walking.ground_truth()->size() > 100);
  const Sequence desk = Sequence::open(data / "tum_fr1_xyz");
  CHECK(desk.size() == 40);
  CHECK(desk.camera().distortion[0] == 0.2624);
}

}  // namespace tum_sequence_test
