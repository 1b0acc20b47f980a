// SPDX-License-Identifier: MIT
#include <string>

#include "doctest/doctest.h"
#include "io/trajectory_formats.hpp"
#include "io/tum_folder.hpp"

namespace trajectory_formats_test {

using namespace dynfilter;
using namespace dynfilter_test;

namespace {

class Files {
 public:
  std::filesystem::path operator()(const std::string& name, const std::string& text) const {
    write_text(folder_.path() / name, text);
    return folder_.path() / name;
  }

 private:
  TemporaryFolder folder_;
};

std::string complaint(const std::filesystem::path& file,
                      std::optional<io::TrajectoryFormat> format = std::nullopt) {
  try {
    io::read_trajectory(file, format);
  } catch (const IoError& error) {
    return error.what();
  }
  return "";
}

// A quarter turn about z, at (1, 2, 3).
constexpr const char* kKitti = "0 -1 0 1  1 0 0 2  0 0 1 3\n";

}  // namespace

TEST_CASE("trajectory formats: one pose, written in each of them") {
  const Files file;
  const std::string half = "0.707106781186548";
  const io::TrajectoryFile tum = io::read_trajectory(
                               file("a.txt", "1.5 1 2 3 0 0 " + half + " " + half + "\n")),
                           kitti = io::read_trajectory(file("b.txt", std::string(kKitti) + kKitti)),
                           euroc = io::read_trajectory(file("c.csv", "#timestamp\n1500000000,1,2,3," + half +
                                                                         ",0,0," + half + ",9,9,9\n"));
  CHECK(tum.format == io::TrajectoryFormat::Tum);
  CHECK(kitti.format == io::TrajectoryFormat::Kitti);
  CHECK(euroc.format == io::TrajectoryFormat::Euroc);
  CHECK(tum.trajectory[0].timestamp_s == 1.5);
  CHECK(euroc.trajectory[0].timestamp_s == doctest::Approx(1.5));
  CHECK(kitti.trajectory[0].timestamp_s == 0);
  CHECK(kitti.trajectory[1].timestamp_s == doctest::Approx(0.1));
  const Pose& expected = tum.trajectory[0].T_world_camera;
  const io::TrajectoryFile commas = io::read_trajectory(file("d.csv", "1.5,1,2,3,0,0,0,1\n"));
  CHECK(commas.format == io::TrajectoryFormat::Tum);
  const io::TrajectoryFile short_euroc =
      io::read_trajectory(file("e.csv", "1403636579763555584,1,2,3,1,0,0,0\n"));
  CHECK(short_euroc.format == io::TrajectoryFormat::Euroc);
  CHECK((short_euroc.trajectory[0].T_world_camera.R() - Eigen::Matrix3d::Identity()).norm() < 1e-9);
  CHECK(expected.rotation[3] == doctest::Approx(1));  // x goes to y
  for (const io::TrajectoryFile* other : {&kitti, &euroc}) {
    const Pose& pose = other->trajectory[0].T_world_camera;
    CHECK(pose.translation_m == expected.translation_m);
    CHECK((pose.R() - expected.R()).norm() < 1e-9);
  }
}

TEST_CASE("trajectory formats: KITTI's poses with times, too few of them, and what is no pose") {
  const Files file;
  const auto two = file("two.txt", std::string(kKitti) + kKitti);
  const io::TrajectoryFile timed =
      io::read_trajectory(two, std::nullopt, io::read_times_s(file("times.txt", "7.5e0\n8\n9\n")));
  CHECK(timed.trajectory[0].timestamp_s == 7.5);
  CHECK(timed.trajectory[1].timestamp_s == 8);
  CHECK_THROWS_WITH_AS(io::read_trajectory(two, std::nullopt, {1.0}),
                       (two.string() + ": 2 poses, but only 1 times").c_str(), IoError);
  const auto mirror = file("mirror.txt", "-1 0 0 1 0 1 0 2 0 0 1 3\n");
  CHECK(complaint(mirror) == mirror.string() + ":1: is not a rotation and a translation");
  const auto ragged = file("ragged.txt", std::string(kKitti) + "1 2 3\n");
  CHECK(complaint(ragged) == ragged.string() + ":2: expected the 12 numbers of a KITTI pose, found 3 fields");
  const auto euroc = file("short.csv", "1,2,3\n");
  CHECK(complaint(euroc, io::TrajectoryFormat::Euroc) ==
        euroc.string() + ":1: expected 'timestamp[ns],tx,ty,tz,qw,qx,qy,qz', found 3 fields");
  CHECK(complaint(file("empty.txt", "# nothing\n")).find("contains no pose") != std::string::npos);
}

TEST_CASE("trajectory formats: nanoseconds in a TUM file are told by their steps, not by their size") {
  const Files file;
  const std::string pose = " 0 0 0 0 0 0 1\n";
  const auto read = [&](const std::string& text) { return io::read_trajectory(file("t.txt", text)); };
  const io::TrajectoryFile from_zero = read("0" + pose + "50000000" + pose + "100000000" + pose);
  CHECK(from_zero.nanoseconds);
  CHECK(from_zero.trajectory[2].timestamp_s == doctest::Approx(0.1));
  CHECK(read("1403636579763555584" + pose).nanoseconds);
  CHECK(!read("1403636579.76" + pose + "1403636579.81" + pose).nanoseconds);
  CHECK(!read("0" + pose + "3600" + pose).nanoseconds);  // an hour
}

}  // namespace trajectory_formats_test
