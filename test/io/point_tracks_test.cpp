// SPDX-License-Identifier: MIT

#include "io/point_tracks.hpp"
#include "doctest/doctest.h"
#include "io/tum_folder.hpp"
#include "support/time_limit.hpp"

namespace point_tracks_test {

using namespace dynfilter::io;
using namespace dynfilter_test;

namespace {

constexpr const char* kGood =
    "# KT3DMoSeg clip\n# points 3 frames 2 width 640 height 480\n# label then x y per frame\n"
    "1 10 20 30.5 40\n2 nan nan 5 6\n0 7 8 nan nan\n";

}  // namespace

TEST_CASE("a track file is read") {
  const TemporaryFolder folder;
  write_text(folder.path() / "t.txt", kGood);
  const PointTracks tracks = read_point_tracks(folder.path() / "t.txt");
  CHECK(tracks.title == "KT3DMoSeg");
  CHECK(tracks.points == 3);
  CHECK(tracks.frames == 2);
  CHECK(tracks.width_px == 640);
  CHECK(tracks.height_px == 480);
  CHECK(tracks.label == std::vector<int>{1, 2, 0});
  CHECK(tracks.at(0, 1) == cv::Point2f(30.5F, 40));
  CHECK_FALSE(tracks.visible(1, 0));
  CHECK(tracks.last_visible(0) == 1);
  CHECK(tracks.last_visible(2) == 0);
}

TEST_CASE("broken track files: an error that names file and line") {
  const TemporaryFolder folder;
  const auto path = folder.path() / "t.txt";
  const auto complaint = [&](const std::string& text) -> std::string {
    write_text(path, text);
    try {
      read_point_tracks(path);
    } catch (const dynfilter::IoError& error) {
      return error.what();
    }
    return "";
  };
  const std::string header = "# points 1 frames 2 width 640 height 480\n", at = path.string();
  CHECK(complaint("1 2 3 4 5\n") == at + ": expected the header '# points P frames F width W height H'");
  CHECK(complaint("# points 0 frames 2 width 640 height 480\n") ==
        at + ": expected the header '# points P frames F width W height H'");
  CHECK(complaint(header) == at + ": the header says 1 points, there are 0");
  CHECK(complaint(header + "1 2 3 4\n") == at + ":2: expected a label and 2 times 'x y', found 4 fields");
  CHECK(complaint(header + "1 2 3 4 five\n") == at + ":2: 'five' is not a number");
  CHECK(complaint(header + "1.5 2 3 4 5\n") == at + ":2: the label '1.5' is not a whole number");
  CHECK(complaint(header + "-1 2 3 4 5\n") == at + ":2: the label '-1' is not a whole number");
  CHECK_THROWS_AS(read_point_tracks(folder.path() / "absent.txt"), dynfilter::IoError);
}

TEST_CASE("the widest label covers the most cells, whatever its points") {
  const TemporaryFolder folder;
  std::string text = "# points 7 frames 1 width 800 height 800\n";
  for (int i = 0; i < 4; ++i) text += "2 " + std::to_string(10 + i) + " 10\n";        // one cell
  for (int i = 0; i < 3; ++i) text += "5 " + std::to_string(50 + 300 * i) + " 10\n";  // three
  write_text(folder.path() / "t.txt", text);
  CHECK(widest_label(read_point_tracks(folder.path() / "t.txt")) == 5);
}

TEST_CASE("100,000 labels take less than 2 s") {
  PointTracks tracks;
  tracks.points = 100'000, tracks.frames = 2, tracks.width_px = 800, tracks.height_px = 800;
  for (int p = 0; p < tracks.points; ++p) {
    tracks.label.push_back(tracks.points - p);
    tracks.px.emplace_back(10.0F, 10.0F);
    tracks.px.emplace_back(p == 70'000 ? 500.0F : 11.0F, 10.0F);  // this one gets into two cells
  }
  int widest = 0;
  CHECK(dynfilter_test::seconds([&] { widest = widest_label(tracks); }) < dynfilter_test::kMost_s);
  CHECK(widest == tracks.points - 70'000);
}

}  // namespace point_tracks_test
