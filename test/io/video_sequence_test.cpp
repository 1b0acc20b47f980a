// SPDX-License-Identifier: MIT
#ifdef DYNFILTER_HAS_VIDEOIO
#include <cmath>
#include <fstream>
#include <opencv2/imgproc.hpp>

#include "doctest/doctest.h"
#include "io/sequence.hpp"
#include "io/video_samples.hpp"
#include "support/time_limit.hpp"

namespace video_sequence_test {

using namespace dynfilter;
using namespace dynfilter_test;
namespace fs = std::filesystem;

namespace {

std::string complaint(const fs::path& source, const io::SequenceOptions& options = {}) {
  try {
    const io::Sequence sequence = io::Sequence::open(source, options);
    for (std::size_t i = 0; i < sequence.size(); ++i) sequence.load(i);
    return "";
  } catch (const Error& error) {
    CHECK(std::string(error.what()).find('\n') == std::string::npos);
    return error.what();
  }
}

void has(const std::string& text, const std::string& part) {
  CAPTURE(text);
  CHECK(text.find(part) != std::string::npos);
}

bool says(const io::Sequence& sequence, const std::string& part) {
  for (const std::string& note : sequence.notes())
    if (note.find(part) != std::string::npos) return true;
  return false;
}

int number_shown(const io::SequenceFrame& frame) {
  return cvRound(cv::mean(frame.grey)[0] / kGreyStep);
}

/// Resident memory of this process [MB].
[[maybe_unused]] double resident_mb() {
  std::ifstream in("/proc/self/statm");
  double pages = 0, resident = 0;
  in >> pages >> resident;
  return resident * 4096 / 1e6;
}

}  // namespace

TEST_CASE("a video is a sequence: frames in order, the container's stamps, an unknown camera") {
  const TemporaryFolder folder;
  for (const char* name : {"clip.avi", "clip.mp4"}) {
    CAPTURE(name);
    const fs::path file = folder.path() / name;
    write_video(file, 10);
    const io::Sequence sequence = io::Sequence::open(file);
    CHECK(sequence.size() == 10);
    CHECK(sequence.is_stream());
    CHECK_FALSE(sequence.is_camera());
    CHECK(sequence.name() == name);
    CHECK(sequence.image_name(3) == "000003");
    CHECK(sequence.rate_hz() == doctest::Approx(10));
    CHECK_FALSE(sequence.has_depth());
    CHECK_FALSE(sequence.ground_truth());
    for (const std::size_t i : {0U, 1U, 2U, 5U, 9U, 4U, 4U, 0U}) {  // forwards, with gaps, and back
      const io::SequenceFrame frame = sequence.load(i);
      CHECK(number_shown(frame) == static_cast<int>(i));
      CHECK(frame.timestamp_s == doctest::Approx(0.1 * static_cast<double>(i)));
      CHECK(sequence.timestamp_s(i) == frame.timestamp_s);
    }
    CHECK_FALSE(sequence.read(10));
    CHECK(sequence.camera_is_guessed());
    CHECK(sequence.camera().fx_px == 64);
    CHECK(sequence.camera().cx_px == doctest::Approx(31.5));
    CHECK(says(sequence, "guessed as 64 pixels, the larger side of the image; --camera"));
    CHECK(sequence.notes().size() == 1);
  }
}

TEST_CASE("stamps of a variable rate are the container's; where they do not increase, frames are counted") {
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "clip.mp4";
  write_video(file, 10);
  SUBCASE("variable") {
    set_durations(file, {{3, 1}, {2, 2}, {5, 0.5}});
    const io::Sequence sequence = io::Sequence::open(file);
    const double expected_s[] = {0, 0.1, 0.2, 0.3, 0.5, 0.7, 0.75, 0.8, 0.85, 0.9};
    for (std::size_t i = 0; i < 10; ++i)
      CHECK(sequence.load(i).timestamp_s == doctest::Approx(expected_s[i]).epsilon(1e-3));
    CHECK(sequence.notes().size() == 1);
  }
  SUBCASE("standing still") {
    set_durations(file, {{4, 1}, {3, 0}, {3, 1}});
    const io::Sequence sequence = io::Sequence::open(file);
    double last_s = -1;
    for (std::size_t i = 0; i < sequence.size(); ++i) {
      const double now_s = sequence.load(i).timestamp_s;
      CHECK(now_s > last_s);
      last_s = now_s;
    }
    CHECK(says(sequence, "do not increase at frame 5: from there they are counted by the frame rate"));
  }
}

TEST_CASE("a video that was taken upright is upright") {
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "phone.mp4";
  write_video(file, 3, {64, 48});
  turn_video(file);
  const io::Sequence sequence = io::Sequence::open(file);
  CHECK(sequence.load(0).grey.size() == cv::Size(48, 64));
  CHECK(sequence.camera().width_px == 48);
  CHECK(sequence.camera().fx_px == 64);
}

TEST_CASE("a broken frame in the middle is skipped and said") {
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "clip.avi";
  write_video(file, 10);
  break_frame(file, 4);
  const io::Sequence sequence = io::Sequence::open(file);
  std::vector<int> shown;
  std::vector<double> stamps_s;
  for (std::size_t i = 0; i < sequence.size(); ++i)
    if (const auto frame = sequence.read(i))
      shown.push_back(number_shown(*frame)), stamps_s.push_back(frame->timestamp_s);
  CHECK(shown == std::vector<int>{0, 1, 2, 3, 5, 6, 7, 8, 9});
  CHECK(stamps_s[4] == doctest::Approx(0.5));
  CHECK(says(sequence, "1 of 10 frames could not be decoded and are skipped"));
}

TEST_CASE("what is no video gets one line that says what is accepted") {
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "clip.mp4";
  const auto write = [&](const char* name, const std::string& text) {
    write_text(folder.path() / name, text);
    return folder.path() / name;
  };
  has(complaint(write("notes.txt", "not a video\n")), "notes.txt: is no video that OpenCV can read");
  has(complaint(write("notes.txt", "not a video\n")), "accepted are a folder, a video file (mp4");
  has(complaint(write("empty.mp4", "")), "empty.mp4: is no video");
  write_video(file, 10);
  fs::resize_file(file, fs::file_size(file) / 2);
  has(complaint(file), "clip.mp4: is no video that OpenCV can read, or its end is missing");
  has(complaint(folder.path() / "nothing.mp4"), "nothing.mp4: no such folder or file");
  write_text(folder.path() / "one.png", "x");
  has(complaint(folder.path() / "one.png"), "is one image; give its folder, or a pattern as 'frames/*.png'");
  has(complaint("rtsp://example.invalid/a"), "is given as camera:rtsp://example.invalid/a");
  has(complaint("/dev/null"), "is given as camera:/dev/null");
  write_video(folder.path() / "none.avi", 10);
  for (int n = 0; n < 10; ++n) break_frame(folder.path() / "none.avi", 0);
  has(complaint(folder.path() / "none.avi"), "none.avi: has no frame that can be decoded");
}

TEST_CASE("a truncated file plays as far as it goes, and it is said") {
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "clip.avi";
  write_video(file, 30);
  fs::resize_file(file, fs::file_size(file) * 6 / 10);
  const io::Sequence sequence = io::Sequence::open(file);
  std::size_t frames = 0;
  while (frames < sequence.size() && sequence.read(frames)) ++frames;
  CHECK(frames > 5);
  CHECK(frames < 30);
  CHECK(says(sequence, "says that it has 30 frames, but holds"));
}

TEST_CASE("a folder named as a video is a folder") {
  const TemporaryFolder folder;
  const fs::path named = folder.path() / "x.mp4";
  has((fs::create_directories(named), complaint(named)), "x.mp4: is no sequence");
  cv::imwrite((named / "1.png").string(), cv::Mat(12, 16, CV_8UC3, cv::Scalar(1)));
  const io::Sequence sequence = io::Sequence::open(named);
  CHECK_FALSE(sequence.is_stream());
  CHECK(sequence.load(0).grey.size() == cv::Size(16, 12));
}

TEST_CASE("too wide for one frame a second: --scale") {
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "wide.avi";
  write_video(file, 2, {16000, 16});
  has(complaint(file),
      "is 16000x16, and at most 8192 pixels a side are processed; make it smaller with --scale");
  io::SequenceOptions smaller;
  smaller.scale = 0.25;
  const io::Sequence sequence = io::Sequence::open(file, smaller);
  CHECK(sequence.load(1).grey.size() == cv::Size(4000, 4));
  CHECK(sequence.load(1).colour.size() == cv::Size(4000, 4));
}

TEST_CASE("a scaled image has a scaled camera, and the camera must fit the stored image") {
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "clip.avi";
  write_video(file, 2);
  io::SequenceOptions options;
  options.scale = 0.5;
  options.camera.emplace();
  options.camera->fx_px = 50, options.camera->fy_px = 52, options.camera->cx_px = 31.5,
  options.camera->cy_px = 23.5;
  options.camera->width_px = 64, options.camera->height_px = 48;
  const io::Sequence sequence = io::Sequence::open(file, options);
  CHECK_FALSE(sequence.camera_is_guessed());
  CHECK(sequence.notes().empty());
  CHECK(sequence.camera().fx_px == 25);
  CHECK(sequence.camera().fy_px == 26);
  CHECK(sequence.camera().cx_px == 15.5);  // the centre remains the centre
  CHECK(sequence.camera().cy_px == 11.5);
  CHECK(sequence.camera().width_px == 32);
  CHECK(sequence.load(0).grey.size() == cv::Size(32, 24));
  options.camera->width_px = 640;
  has(complaint(file, options), "clip.avi: is 64x48, but the camera is for 640x48; give another camera file");
}

TEST_CASE("a camera that is not there; a stream's address") {
#ifndef DYNFILTER_SANITIZED  // libraries that look for cameras leak
  has(complaint("camera:97"), "camera:97: no image comes from this camera");
#endif
  has(complaint("camera:"), "camera:: give the camera's number, as camera:0");
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "clip.avi";
  write_video(file, 5);
  const io::Sequence camera = io::Sequence::open("camera:" + file.string());  // as a device that ends
  CHECK(camera.is_camera());
  CHECK(camera.size() > 100'000);
  double last_s = -1;
  for (std::size_t i = 0; i < 5; ++i) {
    const auto frame = camera.read(i);
    REQUIRE(frame);
    CHECK(number_shown(*frame) == static_cast<int>(i));
    CHECK(frame->timestamp_s > last_s);
    last_s = frame->timestamp_s;
  }
  CHECK_FALSE(camera.read(5));
  CHECK_THROWS_AS(camera.read(0), IoError);
}

TEST_CASE("images by a pattern, numbers in the order of numbers") {
  const TemporaryFolder folder;
  for (const char* name : {"img_2.png", "img_10.png", "img_1.png", "other.png", "img_3.txt"})
    cv::imwrite((folder.path() / name).string() + (std::string(name).back() == 't' ? ".png" : ""),
                cv::Mat(12, 16, CV_8UC3, cv::Scalar(1)));
  const io::Sequence sequence = io::Sequence::open(folder.path() / "img_*0.png");
  CHECK(sequence.size() == 1);
  const io::Sequence all = io::Sequence::open(folder.path() / "img_?*.png");
  REQUIRE(all.size() == 4);
  CHECK(all.image_name(0) == "img_1");
  CHECK(all.image_name(1) == "img_2");
  CHECK(all.image_name(2) == "img_3.txt");
  CHECK(all.image_name(3) == "img_10");
  CHECK(all.camera_is_guessed());
  CHECK(all.camera().fx_px == 16);
  CHECK(says(all, "played at 30 Hz"));
  CHECK(all.timestamp_s(3) == doctest::Approx(0.1));
  has(complaint(folder.path() / "*.jpg"), "*.jpg: no PNG, JPEG, PGM, PPM or BMP image fits this pattern");
  has(complaint(folder.path() / "*" / "1.png"), "only the name of the file may have wildcards");
}

#ifndef DYNFILTER_SANITIZED  // they keep what is freed
TEST_CASE("memory does not grow with the length of a video") {
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "long.avi";
  write_video(file, 2000, {160, 120}, 30);
  const io::Sequence sequence = io::Sequence::open(file);
  double warm_mb = 0;
  for (std::size_t i = 0; i < sequence.size(); ++i) {
    sequence.load(i);
    if (i == 200) warm_mb = resident_mb();
  }
  CHECK(resident_mb() - warm_mb < 10);  // all images are 173 MB
}
#endif

}  // namespace video_sequence_test
#endif
