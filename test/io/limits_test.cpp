// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <dynfilter/config/camera_file.hpp>
#include <dynfilter/config/text_lines.hpp>
#include <dynfilter/core/limits.hpp>
#include <dynfilter/detectors/detections.hpp>
#include <dynfilter/detectors/image_file.hpp>
#include <fstream>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <random>
#include <tuple>

#include "doctest/doctest.h"
#include "io/association.hpp"
#include "io/point_tracks.hpp"
#include "io/tum_folder.hpp"
#include "support/time_limit.hpp"

namespace limits_test {

using namespace dynfilter::io;
using namespace dynfilter_test;
using dynfilter::IoError;
namespace fs = std::filesystem;
namespace limits = dynfilter::limits;

namespace {

using Pairs = std::vector<std::pair<std::size_t, std::size_t>>;

/// All close pairs, sorted by gap.
Pairs associate_all_pairs(const std::vector<double>& a_s, const std::vector<double>& b_s, double max_gap_s) {
  std::vector<std::tuple<double, std::size_t, std::size_t>> close;
  for (std::size_t i = 0; i < a_s.size(); ++i)
    for (std::size_t j = 0; j < b_s.size(); ++j)
      if (std::abs(a_s[i] - b_s[j]) < max_gap_s) close.emplace_back(std::abs(a_s[i] - b_s[j]), i, j);
  std::sort(close.begin(), close.end());
  std::vector<bool> a_taken(a_s.size()), b_taken(b_s.size());
  Pairs pairs;
  for (const auto& [gap_s, i, j] : close) {
    if (a_taken[i] || b_taken[j]) continue;
    a_taken[i] = b_taken[j] = true;
    pairs.emplace_back(i, j);
  }
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

std::vector<double> stamps(std::mt19937& random, int n, int most) {
  std::vector<double> result;
  for (int k = 0; k < n; ++k) result.push_back(std::uniform_int_distribution<int>(0, most)(random) / 64.0);
  std::sort(result.begin(), result.end());
  result.erase(std::unique(result.begin(), result.end()), result.end());
  return result;
}

void write_bytes(const fs::path& path, const std::vector<unsigned char>& bytes) {
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

}  // namespace

TEST_CASE("association equals the greedy choice among all pairs") {
  std::mt19937 random(3);
  for (int trial = 0; trial < 300; ++trial) {
    // Stamps on a grid of 1/64 s: many gaps are equal.
    const std::vector<double> a_s = stamps(random, trial % 40, 100), b_s = stamps(random, trial % 23, 100);
    CAPTURE(trial);
    CHECK(associate(a_s, b_s, 0.1) == associate_all_pairs(a_s, b_s, 0.1));
  }
}

TEST_CASE("association of 200,000 stamps that are all close takes less than 2 s") {
  constexpr std::size_t kStamps = 200'000;
  std::vector<double> a_s, b_s;
  for (std::size_t k = 0; k < kStamps; ++k) {
    a_s.push_back(1e-8 * static_cast<double>(k));
    b_s.push_back(1e-8 * (static_cast<double>(k) + 0.25));
  }
  Pairs pairs;
  CHECK(seconds([&] { pairs = associate(a_s, b_s, 0.02); }) < kMost_s);
  REQUIRE(pairs.size() == kStamps);
  CHECK(std::all_of(pairs.begin(), pairs.end(), [](const auto& pair) { return pair.first == pair.second; }));
}

TEST_CASE("an image beyond the limits, or of another size than asked for, is not decoded") {
  const TemporaryFolder folder;
  // Headers without pixels: decoding them would fail with another message.
  const std::string wide = "P5\n" + std::to_string(limits::kMaxImageSide_px + 1) + " 1\n255\n",
                    large = "P5\n16384 16384\n255\n", small = "P5\n16 16\n255\n";
  for (const std::string& header : {wide, large}) {
    write_text(folder.path() / "a.pgm", header);
    CHECK_THROWS_WITH_AS(read_image(folder.path() / "a.pgm", ImageAs::Colour),
                         doctest::Contains("expected at most 16384 on a side and 67108864 pixels"), IoError);
  }
  write_text(folder.path() / "b.pgm", small);
  cv::Size seen;
  const auto check = [&](const cv::Size& size) {
    seen = size;
    throw IoError("another size");
  };
  CHECK_THROWS_WITH_AS(read_image(folder.path() / "b.pgm", ImageAs::Colour, check), "another size", IoError);
  CHECK(seen == cv::Size(16, 16));
  std::vector<unsigned char> jpeg;
  REQUIRE(cv::imencode(".jpg", cv::Mat(20, 30, CV_8UC1, cv::Scalar(9)), jpeg));
  write_bytes(folder.path() / "c.jpg", jpeg);
  CHECK_THROWS_WITH_AS(read_image(folder.path() / "c.jpg", ImageAs::Colour, check), "another size", IoError);
  CHECK(seen == cv::Size(30, 20));
}

TEST_CASE("a line or a file that is too long is refused, one as long as allowed is read") {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "lines.txt";
  const std::string longest(limits::kMaxLineBytes, 'x');
  for (const char* end : {"", "\n", "\nlast\n"}) {
    write_text(path, "first\n" + longest + end);
    const auto lines = read_text_lines(path);
    REQUIRE(lines.size() >= 2);
    CHECK(lines[1].fields[0].size() == limits::kMaxLineBytes);
    CHECK(lines[1].number == 2);
  }
  write_text(path, "first\n\n" + longest + "x\nlast\n");
  CHECK_THROWS_WITH_AS(read_text_lines(path), doctest::Contains("lines.txt:3: has more than 1048576 bytes"),
                       IoError);
  CHECK_THROWS_WITH_AS(read_camera(path), doctest::Contains("lines.txt:3: has more than"), IoError);
  write_text(path, "#" + longest);
  CHECK_THROWS_WITH_AS(read_point_tracks(path), doctest::Contains("lines.txt:1: has more than"), IoError);
  write_text(path, "\n\r\n a b\r\n");
  const auto lines = read_text_lines(path);
  REQUIRE(lines.size() == 1);
  CHECK(lines[0].number == 3);
  CHECK(lines[0].fields == std::vector<std::string>{"a", "b"});
}

TEST_CASE("boxes of one image are limited, and class names have no control characters") {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "boxes.txt";
  std::string text;
  for (std::size_t k = 0; k < limits::kMaxBoxes; ++k) text += "10 0 per\x1B[2Json 0.9 10 20 30 60\n";
  write_text(path, text + "11 0 person 0.9 10 20 30 60\n");
  const DetectionTrack track = read_detections(path);
  CHECK(track.at(10)->size() == limits::kMaxBoxes);
  CHECK(track.at(10)->front().class_name == "per?[2Json");
  write_text(path, text + "10 0 person 0.9 10 20 30 60\n");
  CHECK_THROWS_WITH_AS(read_detections(path), doctest::Contains("boxes.txt:1001: more than 1000 boxes"),
                       IoError);
}

}  // namespace limits_test
