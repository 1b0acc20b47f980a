// SPDX-License-Identifier: MIT

#include "io/trajectory.hpp"
#include "doctest/doctest.h"
#include "io/tum_folder.hpp"

namespace trajectory_test {

using namespace dynfilter::io;
using namespace dynfilter_test;

TEST_CASE("what is written is read back") {
  const TemporaryFolder folder;
  Trajectory written;
  for (int i = 0; i < 7; ++i) {
    const Eigen::AngleAxisd turn(0.9 * i, Eigen::Vector3d(1, i, -2).normalized());
    written.push_back({1341846434.710184 + 0.033 * i,
                       dynfilter::Pose::from(turn.toRotationMatrix(), {0.1 * i, -2.5, 1e-3 * i})});
  }
  write_tum_trajectory(folder.path() / "t.txt", written);
  const Trajectory read = read_tum_trajectory(folder.path() / "t.txt");
  REQUIRE(read.size() == written.size());
  for (std::size_t i = 0; i < read.size(); ++i) {
    CHECK(std::abs(read[i].timestamp_s - written[i].timestamp_s) < 1e-6);
    CHECK((read[i].T_world_camera.R() - written[i].T_world_camera.R()).norm() < 1e-8);
    CHECK((read[i].T_world_camera.t() - written[i].T_world_camera.t()).norm() < 1e-8);
  }
}

TEST_CASE(
    "comments, commas, tabs, NaN lines, zero quaternions, order and repeats are taken as the TUM tools do") {
  const TemporaryFolder folder;
  const auto path = folder.path() / "t.txt";
  write_text(path,
             "# stamp\n3,1,2,3,0,0,0,2\r\n\n1.5\t0 0 0\t0 0 1 0 \n2 nan 0 0 0 0 0 1\n2.5 0 0 0 0 0 0 0\n"
             "1.5 9 0 0 0 0 0 1 extra\n");
  const Trajectory read = read_tum_trajectory(path);
  REQUIRE(read.size() == 2);
  CHECK(read[0].timestamp_s == 1.5);
  CHECK(read[0].T_world_camera.t().x() == 9);  // the later line of one stamp
  CHECK(read[1].T_world_camera.t() == Eigen::Vector3d(1, 2, 3));
  CHECK((read[1].T_world_camera.R() - Eigen::Matrix3d::Identity()).norm() < 1e-15);  // normalised
}

TEST_CASE("broken trajectories: an error that names file and line") {
  const TemporaryFolder folder;
  const auto path = folder.path() / "t.txt";
  const auto complaint = [&](const char* text) -> std::string {
    write_text(path, text);
    try {
      read_tum_trajectory(path);
    } catch (const dynfilter::IoError& error) {
      return error.what();
    }
    return "";
  };
  CHECK(complaint("1 0 0 0 0 0 0 1\n2 0 0 0\n") ==
        path.string() + ":2: expected 'timestamp tx ty tz qx qy qz qw', found 4 fields");
  CHECK(complaint("# c\n1 0 zero 0 0 0 0 1\n") == path.string() + ":2: 'zero' is not a number");
  CHECK(complaint("# only a comment\n") == path.string() + ": contains no pose");
  CHECK_THROWS_AS(read_tum_trajectory(folder.path() / "absent.txt"), dynfilter::IoError);
  CHECK_THROWS_AS(read_tum_trajectory(folder.path()), dynfilter::IoError);
}

}  // namespace trajectory_test
