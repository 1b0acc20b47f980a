// SPDX-License-Identifier: MIT
#pragma once

#include <ceres/ceres.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <deque>
#include <vector>

#include "map.hpp"
#include "projection.hpp"

namespace dynfilter::odometry {

/// Poses as seven numbers: translation, then quaternion (x y z w).
/// Costs return the derivatives along the motion exp(xi) T in the first six columns.
/// The derivative of `Plus` is therefore the identity there.
class PoseManifold final : public ceres::Manifold {
 public:
  int AmbientSize() const override { return 7; }
  int TangentSize() const override { return 6; }
  static Eigen::Isometry3d to_pose(const double* x) {
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.linear() = Eigen::Map<const Eigen::Quaterniond>(x + 3).toRotationMatrix();
    T.translation() = Eigen::Map<const Eigen::Vector3d>(x);
    return T;
  }
  static void from_pose(const Eigen::Isometry3d& T, double* x) {
    Eigen::Map<Eigen::Vector3d> t(x);
    Eigen::Map<Eigen::Quaterniond> q(x + 3);
    t = T.translation();
    q = Eigen::Quaterniond(T.linear()).normalized();
  }
  bool Plus(const double* x, const double* delta, double* sum) const override {
    from_pose(moved(to_pose(x), Eigen::Map<const Vector6d>(delta)), sum);
    return true;
  }
  bool PlusJacobian(const double*, double* jacobian) const override {
    Eigen::Map<Eigen::Matrix<double, 7, 6, Eigen::RowMajor>> J(jacobian);
    J.setIdentity();
    return true;
  }
  bool Minus(const double* y, const double* x, double* difference) const override {
    const Eigen::Isometry3d T = to_pose(y) * to_pose(x).inverse();
    const Eigen::AngleAxisd r(T.linear());
    Eigen::Map<Vector6d> d(difference);
    d << to_pose(y).translation() - r * to_pose(x).translation(), r.angle() * r.axis();
    return true;
  }
  bool MinusJacobian(const double*, double* jacobian) const override {
    Eigen::Map<Eigen::Matrix<double, 6, 7, Eigen::RowMajor>> J(jacobian);
    J.setIdentity();
    return true;
  }
};

/// Pixel and disparity residual of one observation, in standard deviations, with analytic derivatives.
class SightingCost final : public ceres::SizedCostFunction<3, 7, 3> {
 public:
  SightingCost(const Pinhole& camera, const Sighting& sighting)
      : camera_(camera), sighting_(sighting), W_(sighting.whitening()) {}

  /// False for a point behind the camera: Evaluate() then fails.
  static bool is_visible(const Eigen::Vector3d& camera_m) { return camera_m.z() > 0.01; }

  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    const Eigen::Quaterniond q = Eigen::Map<const Eigen::Quaterniond>(x[0] + 3);
    const Eigen::Matrix3d R = q.toRotationMatrix();
    const Eigen::Vector3d p =
        R * Eigen::Map<const Eigen::Vector3d>(x[1]) + Eigen::Map<const Eigen::Vector3d>(x[0]);
    if (!is_visible(p)) return false;
    Eigen::Map<Eigen::Vector3d> r(residuals);
    r = W_ * (camera_.project(p) - sighting_.measured_px);
    if (!jacobians) return true;
    const Eigen::Matrix3d J = W_ * camera_.jacobian(p);
    if (jacobians[0]) {
      Eigen::Map<Eigen::Matrix<double, 3, 7, Eigen::RowMajor>> out(jacobians[0]);
      out << J, -J * skew(p), Eigen::Vector3d::Zero();
    }
    if (jacobians[1]) {
      Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> out(jacobians[1]);
      out = J * R;
    }
    return true;
  }

 private:
  Pinhole camera_;
  Sighting sighting_;
  Eigen::Matrix3d W_;
};

/// Ceres also logs what it tells in its summary, to stderr, whatever Solver::Options::logging_type is.
/// While this exists, only fatal errors are logged. Its own miniglog has no such switch.
class SilentLog {
 public:
  SilentLog(const SilentLog&) = delete;
  SilentLog& operator=(const SilentLog&) = delete;
#ifndef CERCES_INTERNAL_MINIGLOG_GLOG_LOGGING_H_
  SilentLog() {
    FLAGS_minloglevel = google::GLOG_FATAL;
  }
  ~SilentLog() {
    FLAGS_minloglevel = before_;
  }

 private:
  decltype(FLAGS_minloglevel) before_ = FLAGS_minloglevel;
#else
  SilentLog() {}
#endif
};

/// Windowed bundle adjustment. The given keyframes and all their points are optimised.
/// Other keyframes that observe these points are fixed.
class BundleAdjuster {
 public:
  BundleAdjuster(const Pinhole& camera, const BundleOptions& options) : camera_(camera), options_(options) {}

  /// Improves `map` in place, then removes observations with large residuals.
  /// `sighting(keyframe, feature)` returns the measurement.
  /// The first keyframe is fixed as long as the map has it.
  template <class SightingOf>
  void adjust(Map& map, const std::vector<std::int32_t>& window, SightingOf&& sighting) {
    select_points(map, window);
    select_keyframes(map, window);
    ceres::Problem::Options problem_options;
    problem_options.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    problem_options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    problem_options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    problem_options.disable_all_safety_checks = true;
    ceres::Problem problem(problem_options);
    auto* ordering = new ceres::ParameterBlockOrdering;
    add_poses(map, problem, *ordering);
    add_points(map, problem, *ordering, sighting);
    solve(problem, ordering);
    write_back(map);
    drop_outliers(map, sighting);
  }

 private:
  struct Block {
    std::array<double, 7> x;
    bool used = false, moves = false;
  };

  Block& block(std::int32_t keyframe) { return blocks_[static_cast<std::size_t>(keyframe - first_)]; }
  const Block& block(std::int32_t keyframe) const {
    return blocks_[static_cast<std::size_t>(keyframe - first_)];
  }
  std::int64_t keyframe(std::size_t block) const { return first_ + static_cast<std::int64_t>(block); }

  void select_points(const Map& map, const std::vector<std::int32_t>& window) {
    points_ = map.points_of(window);
    points_.erase(std::remove_if(points_.begin(), points_.end(),
                                 [&](std::int64_t i) { return map.point(i).observations.size() < 2; }),
                  points_.end());
    const auto limit = static_cast<std::size_t>(options_.max_points);
    if (points_.size() <= limit) return;
    std::stable_sort(points_.begin(), points_.end(), [&](std::int64_t a, std::int64_t b) {
      return map.point(a).observations.size() > map.point(b).observations.size();
    });
    points_.resize(limit);
  }

  void select_keyframes(const Map& map, const std::vector<std::int32_t>& window) {
    first_ = map.keyframes.first();
    blocks_.assign(map.keyframes.count(), Block{});
    for (const std::int32_t k : window) block(k).used = block(k).moves = true;
    const bool has_origin = first_ == 0;
    if (has_origin) block(0).moves = false;
    int fixed = 0;
    for (const std::int32_t k : map.covisible(points_, map.keyframes.count())) {
      if (block(k).used || fixed >= options_.fixed_keyframes) continue;
      block(k).used = true;
      ++fixed;
    }
    // Without a fixed keyframe the window has a free gauge, so its oldest keyframe is fixed.
    if (fixed == 0 && !(has_origin && block(0).used))
      block(*std::min_element(window.begin(), window.end())).moves = false;
  }

  void add_poses(const Map& map, ceres::Problem& problem, ceres::ParameterBlockOrdering& ordering) {
    for (std::size_t k = 0; k < blocks_.size(); ++k) {
      if (!blocks_[k].used) continue;
      PoseManifold::from_pose(map.keyframes[keyframe(k)].T_camera_world, blocks_[k].x.data());
      problem.AddParameterBlock(blocks_[k].x.data(), 7, &manifold_);
      ordering.AddElementToGroup(blocks_[k].x.data(), 1);
      if (!blocks_[k].moves) problem.SetParameterBlockConstant(blocks_[k].x.data());
    }
  }

  template <class SightingOf>
  void add_points(const Map& map, ceres::Problem& problem, ceres::ParameterBlockOrdering& ordering,
                  SightingOf&& sighting) {
    costs_.clear();
    positions_.resize(points_.size());
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const MapPoint& point = map.point(points_[i]);
      positions_[i] = point.world_m;
      bool used = false;
      for (const Observation& o : point.observations) {
        if (!block(o.keyframe).used) continue;
        // A single sighting that cannot be evaluated would end the whole adjustment.
        if (!SightingCost::is_visible(map.keyframes[o.keyframe].T_camera_world * point.world_m)) continue;
        costs_.emplace_back(camera_, sighting(o));
        problem.AddResidualBlock(&costs_.back(), &huber_, block(o.keyframe).x.data(), positions_[i].data());
        used = true;
      }
      if (used) ordering.AddElementToGroup(positions_[i].data(), 0);
    }
  }

  void solve(ceres::Problem& problem, ceres::ParameterBlockOrdering* ordering) const {
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::DENSE_SCHUR;
    options.dense_linear_algebra_library_type = ceres::EIGEN;
    options.linear_solver_ordering.reset(ordering);
    options.max_num_iterations = options_.max_iterations;
    options.num_threads = 1;
    options.function_tolerance = 1e-4;
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    const SilentLog silent;
    ceres::Solve(options, &problem, &summary);
  }

  void write_back(Map& map) const {
    for (std::size_t k = 0; k < blocks_.size(); ++k)
      if (blocks_[k].moves) map.keyframes[keyframe(k)].set_pose(PoseManifold::to_pose(blocks_[k].x.data()));
    for (std::size_t i = 0; i < points_.size(); ++i) map.point(points_[i]).world_m = positions_[i];
  }

  template <class SightingOf>
  void drop_outliers(Map& map, SightingOf&& sighting) const {
    for (const std::int64_t i : points_) {
      const std::vector<Observation> seen = map.point(i).observations;
      for (const Observation& o : seen) {
        if (!block(o.keyframe).used) continue;
        const Sighting s = sighting(o);
        const Eigen::Vector3d p = map.keyframes[o.keyframe].T_camera_world * map.point(i).world_m;
        const bool agrees =
            p.z() > 0.05 &&
            (s.whitening() * (camera_.project(p) - s.measured_px)).squaredNorm() <= s.chi2_limit();
        if (!agrees) map.forget(i, o);
      }
    }
  }

  Pinhole camera_;
  BundleOptions options_;
  PoseManifold manifold_;
  ceres::HuberLoss huber_{2.45};
  std::vector<std::int64_t> points_;
  std::vector<Eigen::Vector3d> positions_;
  std::int32_t first_ = 0;  ///< keyframe of the first block
  std::vector<Block> blocks_;
  std::deque<SightingCost> costs_;  ///< the problem keeps pointers to its elements
};

}  // namespace dynfilter::odometry
