// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Geometry>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/geometry/depth_noise.hpp>
#include <dynfilter/geometry/sampling.hpp>
#include <numeric>
#include <opencv2/core.hpp>
#include <vector>

namespace geometry_test {

constexpr double kPixelSigma = 0.7;

inline dynfilter::Camera camera() {
  dynfilter::Camera c;
  c.fx_px = 535.4, c.fy_px = 539.2, c.cx_px = 320.1, c.cy_px = 247.6;
  return c;
}

/// The larger of translation [m] and rotation [rad] between two poses.
inline double pose_error(const dynfilter::Pose& a, const dynfilter::Pose& b) {
  const Eigen::Matrix3d dR = a.R() * b.R().transpose();
  return std::max((a.t() - b.t()).norm(), (dR - Eigen::Matrix3d::Identity()).norm() / std::sqrt(2.0));
}

/// Compilers differ in the order of a call's arguments: numbers are drawn one by one.
inline Eigen::Vector3d normal_vector(dynfilter::SampleGenerator& rng) {
  const double z = rng.normal(), y = rng.normal(), x = rng.normal();
  return {x, y, z};
}

/// Points of two depth frames under one rigid motion.
/// Pixel noise on the current pixel, depth noise on both depths, outliers anywhere in the view.
struct RigidScene {
  std::vector<cv::Point3f> reference, current;
  dynfilter::Pose truth;

  RigidScene(int n, double outlier_share, int seed, double noise) : rng_(seed), noise_(noise) {
    const Eigen::Vector3d axis = normal_vector(rng_);
    const Eigen::Matrix3d R =
        Eigen::AngleAxisd(rng_.uniform(0.01, 0.06), axis.normalized()).toRotationMatrix();
    truth = dynfilter::Pose::from(R, {rng_.uniform(-0.06, 0.06), rng_.uniform(-0.06, 0.06), 0.03});
    for (int i = 0; i < n; ++i) {
      points_.push_back(ray_within({0, 640}, {0, 480}, {0.8, 4.0}));
      add(points_.back(), truth);
    }
    for (int i = 0; i < outlier_share * n; ++i) {
      current[i] = to_cv(ray_within({0, 640}, {0, 480}, {0.8, 4.0}));
    }
  }

  std::vector<int> all() const {
    std::vector<int> indices(reference.size());
    std::iota(indices.begin(), indices.end(), 0);
    return indices;
  }

  void move_rigidly(int begin, int end, const dynfilter::Pose& extra) {
    for (int i = begin; i < end; ++i) current[i] = measure(extra * truth, points_[i]);
  }

 private:
  struct Range {
    double low, high;
  };
  Eigen::Vector3d ray_within(Range u_px, Range v_px, Range z_m) {
    const double z = rng_.uniform(z_m.low, z_m.high), v = rng_.uniform(v_px.low, v_px.high);
    return ray(rng_.uniform(u_px.low, u_px.high), v, z);
  }
  static Eigen::Vector3d ray(double u, double v, double z) {
    const dynfilter::Camera c = camera();
    return {(u - c.cx_px) / c.fx_px * z, (v - c.cy_px) / c.fy_px * z, z};
  }
  static cv::Point3f to_cv(const Eigen::Vector3d& p) {
    return {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())};
  }
  cv::Point3f noisy_depth(const Eigen::Vector3d& p) {
    const double z = p.z() + noise_ * dynfilter::DepthNoise{}.sigma_m(p.z()) * rng_.normal();
    return to_cv(p * (z / p.z()));
  }
  cv::Point3f measure(const dynfilter::Pose& T, const Eigen::Vector3d& p) {
    Eigen::Vector3d q = T.R() * p + T.t();
    const dynfilter::Camera c = camera();
    q.x() += noise_ * kPixelSigma * rng_.normal() / c.fx_px * q.z();
    q.y() += noise_ * kPixelSigma * rng_.normal() / c.fy_px * q.z();
    return noisy_depth(q);
  }
  void add(const Eigen::Vector3d& p, const dynfilter::Pose& T) {
    reference.push_back(noisy_depth(p));
    current.push_back(measure(T, p));
  }

  dynfilter::SampleGenerator rng_;
  double noise_;
  std::vector<Eigen::Vector3d> points_;
};

}  // namespace geometry_test
