// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Cholesky>
#include <algorithm>
#include <cstdint>
#include <optional>
#include <vector>

#include "projection.hpp"

namespace dynfilter::odometry {

struct PosePoint {
  Eigen::Vector3d world_m;
  Sighting sighting;
};

struct RefinementOptions {
  int rounds = 3;       ///< points are classified into inliers and outliers before each round
  int iterations = 8;   ///< maximum per round
  double huber = 2.45;  ///< in standard deviations
  double acceleration_m_s2 = 9,
         turn_deg_s2 = 450;  ///< change of the camera's motion: 1 cm and 0.5 deg at 30 Hz
};

/// The pose that best explains observations of known points.
/// Levenberg-Marquardt on 6 unknowns with Huber weights over pixel and disparity residuals, then again on the
/// inliers only.
/// Sets `inlier[i]` if point i agrees (95 % chi-square).
/// An expected pose is one additional measurement. It has no effect beside hundreds of points.
/// Two dozen distant points do not separate translation from rotation.
/// Without the expected pose, they would be off by decimetres.
/// Deterministic. Cost: about 0.1 ms for 500 points.
class PoseRefiner {
 public:
  PoseRefiner(const Pinhole& camera, const RefinementOptions& options = {})
      : camera_(camera), options_(options) {}

  /// Adds this pose as a weak prior. `after_s`: time without a measurement.
  void expect(const Eigen::Isometry3d& T_camera_world, double after_s) {
    const double s2 = std::max(after_s, kLeastStep_s) * std::max(after_s, kLeastStep_s);
    const double sigma_m = options_.acceleration_m_s2 * s2,
                 sigma_rad = options_.turn_deg_s2 * s2 * M_PI / 180;
    expected_ = T_camera_world;
    expected_weights_ << Eigen::Vector3d::Constant(1 / (sigma_m * sigma_m)),
        Eigen::Vector3d::Constant(1 / (sigma_rad * sigma_rad));
  }
  void expect_nothing() { expected_.reset(); }

  /// Improves the pose in place. Returns the number of inliers.
  int refine(const std::vector<PosePoint>& points, Eigen::Isometry3d& T_camera_world,
             std::vector<std::uint8_t>& inlier) const {
    inlier.assign(points.size(), 1);
    int count = static_cast<int>(points.size());
    for (int round = 0; round < options_.rounds && count >= kMinPoints; ++round) {
      minimise(points, inlier, T_camera_world);
      count = classify(points, T_camera_world, inlier);
    }
    return count;
  }

  /// Sum of Huber costs over each point's residual vector, half of what ceres::HuberLoss defines.
  double cost(const std::vector<PosePoint>& points, const std::vector<std::uint8_t>& use,
              const Eigen::Isometry3d& T) const {
    return accumulate(points, use, T).cost;
  }

 private:
  static constexpr int kMinPoints = 6;
  static constexpr double kLeastStep_s = 1.0 / 30;
  static constexpr double kNear = 0.05;  // metres; points closer or behind are not used

  struct System {
    Matrix6d H = Matrix6d::Zero();
    Vector6d g = Vector6d::Zero();
    double cost = 0;
  };

  void minimise(const std::vector<PosePoint>& points, const std::vector<std::uint8_t>& use,
                Eigen::Isometry3d& T) const {
    System system = accumulate(points, use, T);
    double damping = 1e-6;
    for (int i = 0; i < options_.iterations; ++i) {
      Matrix6d H = system.H;
      H.diagonal() *= 1 + damping;
      H.diagonal().array() += 1e-9;
      const Vector6d step = -H.ldlt().solve(system.g);
      const Eigen::Isometry3d candidate = moved(T, step);
      const System next = accumulate(points, use, candidate);
      if (!(next.cost <= system.cost)) {
        damping = std::max(1e-4, damping * 10);
        continue;
      }
      const bool done = system.cost - next.cost < 1e-7 * system.cost;
      T = candidate;
      system = next;
      damping *= 0.1;
      if (done) return;
    }
  }

  System accumulate(const std::vector<PosePoint>& points, const std::vector<std::uint8_t>& use,
                    const Eigen::Isometry3d& T) const {
    System system;
    const Eigen::Matrix3d R = T.linear();
    const Eigen::Vector3d t = T.translation();
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (!use[i]) continue;
      const Eigen::Vector3d p = R * points[i].world_m + t;
      if (!(p.z() > kNear)) {
        system.cost += behind_cost();
        continue;
      }
      add(points[i].sighting, p, system);
    }
    if (expected_) add_expected(T, system);
    system.H.triangularView<Eigen::StrictlyUpper>() = system.H.transpose();
    return system;
  }

  void add(const Sighting& sighting, const Eigen::Vector3d& p, System& system) const {
    const Eigen::Matrix3d W = sighting.whitening();
    const Eigen::Vector3d r = W * (camera_.project(p) - sighting.measured_px);
    const double squared = r.squaredNorm(), k = options_.huber;
    const double weight = squared <= k * k ? 1.0 : k / std::sqrt(squared);
    system.cost += 0.5 * (squared <= k * k ? squared : 2 * k * std::sqrt(squared) - k * k);
    const Eigen::Matrix3d Jp = W * camera_.jacobian(p);
    Matrix36d J;
    J << Jp, -Jp * skew(p);
    system.H.triangularView<Eigen::Lower>() += weight * (J.transpose() * J);
    system.g += weight * (J.transpose() * r);
  }

  void add_expected(const Eigen::Isometry3d& T, System& system) const {
    const Eigen::Isometry3d since = T * expected_->inverse();
    const Eigen::AngleAxisd turn(since.linear());
    Vector6d r;
    r << since.translation(), turn.angle() * turn.axis();
    system.cost += 0.5 * r.dot(expected_weights_.cwiseProduct(r));
    system.H.diagonal() += expected_weights_;
    system.g += expected_weights_.cwiseProduct(r);
  }

  double behind_cost() const { return 0.5 * (2 * options_.huber * 1e3); }

  int classify(const std::vector<PosePoint>& points, const Eigen::Isometry3d& T,
               std::vector<std::uint8_t>& inlier) const {
    int count = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Eigen::Vector3d p = T * points[i].world_m;
      const Sighting& s = points[i].sighting;
      inlier[i] = p.z() > kNear &&
                  (s.whitening() * (camera_.project(p) - s.measured_px)).squaredNorm() <= s.chi2_limit();
      count += inlier[i];
    }
    return count;
  }

  Pinhole camera_;
  RefinementOptions options_;
  std::optional<Eigen::Isometry3d> expected_;
  Vector6d expected_weights_ = Vector6d::Zero();
};

}  // namespace dynfilter::odometry
