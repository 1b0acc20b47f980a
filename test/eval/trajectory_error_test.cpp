// SPDX-License-Identifier: MIT
#include <cstdio>
#include <fstream>
#include <map>
#include <sstream>

#include "doctest/doctest.h"
#include "eval/ate.hpp"
#include "eval/rpe.hpp"

using namespace dynfilter;
namespace fs = std::filesystem;

namespace {

// A helix with a turning camera, a pose every `step_s`.
io::Trajectory helix(int n, double step_s) {
  io::Trajectory trajectory;
  for (int i = 0; i < n; ++i) {
    const double s = 0.1 * i;
    const Eigen::AngleAxisd turn(s, Eigen::Vector3d(1, 2, 3).normalized());
    trajectory.push_back(
        {1000 + step_s * i, Pose::from(turn.toRotationMatrix(), {2 * std::cos(s), std::sin(s), 0.3 * s})});
  }
  return trajectory;
}

io::Trajectory moved(const io::Trajectory& trajectory, double scale) {
  const Pose T = Pose::from(Eigen::AngleAxisd(1.2, Eigen::Vector3d(0, 1, 1).normalized()).toRotationMatrix(),
                            {5, -3, 1});
  io::Trajectory result = trajectory;
  for (auto& pose : result) {
    for (double& v : pose.T_world_camera.translation_m) v *= scale;
    pose.T_world_camera = T * pose.T_world_camera;
  }
  return result;
}

std::map<std::string, std::string> published(const fs::path& path) {
  std::map<std::string, std::string> figures;
  std::ifstream in(path);
  for (std::string line; std::getline(in, line);) {
    std::istringstream fields(line);
    std::string key, value;
    if (fields >> key >> value) figures[key] = value;
  }
  return figures;
}

std::string six_digits(double value) {
  char text[64];
  std::snprintf(text, sizeof text, "%.6f", value);
  return text;
}

void check_figures(const std::map<std::string, std::string>& figures, const std::string& prefix,
                   const eval::ErrorStatistics& s) {
  const std::pair<const char*, double> values[] = {{"rmse", s.rmse}, {"mean", s.mean}, {"median", s.median},
                                                   {"std", s.std},   {"min", s.min},   {"max", s.max}};
  for (const auto& [name, value] : values) {
    const auto& shown = name;  // clang 14 captures no structured binding
    CAPTURE(prefix + shown);
    CHECK(figures.at(prefix + name) == six_digits(value));
  }
}

}  // namespace

TEST_CASE("a trajectory that is only elsewhere has no error") {
  const io::Trajectory truth = helix(60, 0.1);
  CHECK(eval::absolute_trajectory_error(truth, moved(truth, 1)).error_m.max < 1e-12);
  const eval::RpeResult rpe = eval::relative_pose_error(truth, moved(truth, 1));
  CHECK(rpe.translation_m.max < 1e-12);
  CHECK(rpe.rotation_deg.max < 1e-5);
}

TEST_CASE("Sim(3) forgives the scale, SE(3) does not, and the scale is found") {
  const io::Trajectory truth = helix(60, 0.1), half = moved(truth, 0.5);
  CHECK(eval::absolute_trajectory_error(truth, half).error_m.rmse > 0.3);
  eval::AteOptions options;
  options.with_scale = true;
  const eval::AteResult ate = eval::absolute_trajectory_error(truth, half, options);
  CHECK(ate.error_m.max < 1e-12);
  CHECK(ate.T_truth_estimate.scale == doctest::Approx(2));
}

TEST_CASE("a mirrored trajectory is aligned by a rotation, not by a reflection") {
  const io::Trajectory truth = helix(60, 0.1);
  io::Trajectory mirrored = truth;
  for (auto& pose : mirrored) pose.T_world_camera.translation_m[0] *= -1;
  const eval::AteResult ate = eval::absolute_trajectory_error(truth, mirrored);
  CHECK(ate.T_truth_estimate.R.determinant() == doctest::Approx(1));
  CHECK(ate.error_m.rmse > 0.01);
}

TEST_CASE("ATE of known displacements: four corners of a square, each moved outwards by d") {
  io::Trajectory truth, estimate;
  const double xy[4][2] = {{1, 1}, {1, -1}, {-1, -1}, {-1, 1}};
  for (int i = 0; i < 4; ++i) {
    truth.push_back(
        {static_cast<double>(i), Pose::from(Eigen::Matrix3d::Identity(), {xy[i][0], xy[i][1], 0})});
    estimate.push_back(
        {i + 0.015, Pose::from(Eigen::Matrix3d::Identity(), {1.1 * xy[i][0], 1.1 * xy[i][1], 0})});
  }
  const eval::AteResult ate = eval::absolute_trajectory_error(truth, estimate);
  CHECK(ate.pairs == 4);
  CHECK(ate.error_m.rmse == doctest::Approx(0.1 * std::sqrt(2.0)));
  CHECK(ate.error_m.std < 1e-9);
  for (auto& pose : estimate) pose.timestamp_s += 0.01;  // 25 ms: no pair any more
  CHECK_THROWS_AS(eval::absolute_trajectory_error(truth, estimate), Error);
}

TEST_CASE("RPE of a constant drift: 1 cm per second sideways and 1 degree per second") {
  io::Trajectory truth, estimate;
  for (int i = 0; i < 40; ++i) {
    const double t = 0.1 * i;
    const Eigen::AngleAxisd drift(t * 3.14159265358979323846 / 180, Eigen::Vector3d::UnitY());
    truth.push_back({t, Pose{}});
    estimate.push_back({t, Pose::from(drift.toRotationMatrix(), Eigen::Vector3d::Zero())});
  }
  CHECK(eval::relative_pose_error(truth, estimate).rotation_deg.mean == doctest::Approx(1));
  CHECK(eval::relative_pose_error(truth, estimate, 2.0).rotation_deg.mean == doctest::Approx(2));
  for (std::size_t i = 0; i < estimate.size(); ++i) {
    estimate[i].T_world_camera =
        Pose::from(Eigen::Matrix3d::Identity(), {0.001 * static_cast<double>(i), 0, 0});
  }
  const eval::RpeResult rpe = eval::relative_pose_error(truth, estimate);
  CHECK(rpe.translation_m.rmse == doctest::Approx(0.01));
  CHECK(rpe.pairs == 29);  // 40 poses: 29 have a partner ten later that is not the very last
  truth.resize(1);
  CHECK_THROWS_AS(eval::relative_pose_error(truth, estimate), Error);
}

TEST_CASE("statistics of 1 2 3 10, by hand") {
  const eval::ErrorStatistics s = eval::statistics({3, 1, 10, 2});
  CHECK(s.mean == 4);
  CHECK(s.median == 2.5);
  CHECK(s.rmse == doctest::Approx(std::sqrt(114.0 / 4)));
  CHECK(s.std == doctest::Approx(std::sqrt(50.0 / 4)));
  CHECK(s.min == 1);
  CHECK(s.max == 10);
  CHECK(std::isnan(eval::statistics({}).rmse));
}

TEST_CASE("every figure that the TUM tools gave for DynaSLAM's trajectories, to the printed digit" *
          doctest::test_suite("shared_data")) {
  const fs::path data = fs::path(DYNFILTER_DATA_DIR) / "trajectories";
  if (!fs::exists(data)) {
    MESSAGE("skipped: no ../shared/data");
    return;
  }
  for (const char* name : {"fr3_sitting_static", "fr3_walk_static", "fr3_walk_xyz"}) {
    CAPTURE(name);
    const io::Trajectory truth = io::read_tum_trajectory(data / name / "groundtruth.txt");
    const io::Trajectory estimate = io::read_tum_trajectory(data / name / "dynaslam.txt");
    const auto ate_figures = published(data / name / "dynaslam_ate.txt");
    const auto rpe_figures = published(data / name / "dynaslam_rpe.txt");
    const eval::AteResult ate = eval::absolute_trajectory_error(truth, estimate);
    CHECK(ate_figures.at("compared_pose_pairs") == std::to_string(ate.pairs));
    check_figures(ate_figures, "absolute_translational_error.", ate.error_m);
    const eval::RpeResult rpe = eval::relative_pose_error(truth, estimate);
    CHECK(rpe_figures.at("compared_pose_pairs") == std::to_string(rpe.pairs));
    check_figures(rpe_figures, "translational_error.", rpe.translation_m);
    eval::ErrorStatistics as_printed = rpe.rotation_deg;
    as_printed.median *= 3.14159265358979323846 / 180;
    check_figures(rpe_figures, "rotational_error.", as_printed);
  }
}
