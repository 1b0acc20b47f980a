// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/geometry/epipolar_distance.hpp>
#include <dynfilter/geometry/sampling.hpp>
#include <numeric>
#include <opencv2/core.hpp>
#include <vector>

#include "geometry/rigid_scene.hpp"

namespace geometry_test {

enum class Relief { General, Plane, FrontalPlane, PlaneAndBox, Room };
enum class Movers { None, Together, Anyhow, TwoGroups, Expanding };

struct TwoViewRecipe {
  Relief relief = Relief::General;
  dynfilter::Pose motion;
  double noise_px = 0;  ///< per coordinate and image
  Movers movers = Movers::None;
  int mover_count = 150;
  double direction_deg = 60;  ///< of the movers' 6 px in the image
  int static_count = 1000;
  int mismatch_count = 0;
  int seed = 1;
};

inline dynfilter::Pose motion(double rotation_deg, Eigen::Vector3d axis, Eigen::Vector3d t) {
  return dynfilter::Pose::from(
      Eigen::AngleAxisd(rotation_deg * CV_PI / 180, axis.normalized()).toRotationMatrix(), t);
}

/// First-order distance [px] of a match to the epipolar variety in the joint image (Sampson; Hartley and
/// Zisserman, eq. 11.9). With equal noise in both images, it has the standard deviation of that noise.
inline double sampson_distance_px(const dynfilter::Matrix9& F, cv::Point2f reference, cv::Point2f current) {
  const auto terms = dynfilter::detail::epipolar_terms(F, reference, current);
  const double norm = std::sqrt(terms.gradient2());
  return norm > 0 ? std::abs(terms.residual) / norm : HUGE_VAL;
}

/// F = K^-T [t]x R K^-1 of a known motion (Hartley and Zisserman, section 9.2), of norm 1.
inline dynfilter::Matrix9 fundamental_from_pose(const dynfilter::Camera& camera,
                                                const dynfilter::Pose& T_current_reference) {
  const Eigen::Vector3d t = T_current_reference.t();
  Eigen::Matrix3d K_inv, across;
  K_inv << 1 / camera.fx_px, 0, -camera.cx_px / camera.fx_px, 0, 1 / camera.fy_px,
      -camera.cy_px / camera.fy_px, 0, 0, 1;
  across << 0, -t.z(), t.y(), t.z(), 0, -t.x(), -t.y(), t.x(), 0;
  const Eigen::Matrix3d F = (K_inv.transpose() * across * T_current_reference.R() * K_inv).normalized();
  return dynfilter::detail::to_array(F);
}

/// Static points first, then movers, then mismatches.
/// Movers have the surfaces of static points and move by 6 px in the current image.
struct TwoViewScene {
  std::vector<cv::Point2f> reference, current;
  int static_count, mover_count;

  explicit TwoViewScene(const TwoViewRecipe& r)
      : static_count(r.static_count),
        mover_count(r.movers == Movers::None ? 0 : r.mover_count),
        rng_(r.seed) {
    for (int i = 0; i < static_count + mover_count; ++i) {
      const Eigen::Vector3d p = surface(r.relief, i);
      const Eigen::Vector2d shift = i < static_count ? Eigen::Vector2d::Zero() : move(r, i - static_count);
      add(pixel(p), pixel(r.motion.R() * p + r.motion.t()) + shift, r.noise_px);
    }
    for (int i = 0; i < r.mismatch_count; ++i) {
      add({rng_.uniform(0, 640), rng_.uniform(0, 480)}, {rng_.uniform(0, 640), rng_.uniform(0, 480)}, 0);
    }
  }

  std::vector<int> all() const {
    std::vector<int> indices(reference.size());
    std::iota(indices.begin(), indices.end(), 0);
    return indices;
  }

 private:
  static Eigen::Vector2d pixel(const Eigen::Vector3d& p) {
    const dynfilter::Camera c = camera();
    return {c.fx_px * p.x() / p.z() + c.cx_px, c.fy_px * p.y() / p.z() + c.cy_px};
  }

  Eigen::Vector3d surface(Relief relief, int i) {
    const dynfilter::Camera c = camera();
    const double u = rng_.uniform(0, 640), v = rng_.uniform(0, 480);
    const Eigen::Vector3d ray((u - c.cx_px) / c.fx_px, (v - c.cy_px) / c.fy_px, 1);
    const double any = rng_.uniform(1, 5), tilted = 2.5 / ray.dot(Eigen::Vector3d(0.5, 0.3, 1));
    switch (relief) {
      case Relief::General:
        return any * ray;
      case Relief::Plane:
        return tilted * ray;
      case Relief::FrontalPlane:
        return 2.5 * ray;
      case Relief::PlaneAndBox:
        return (i % 4 == 0 ? 0.6 : 1.0) * tilted * ray;
      case Relief::Room:
        return (v > 280 ? 3.0 - (v - 280) / 200 * 1.8 : 3.0 + 0.5 * (i % 3 == 0)) * ray;
    }
    return ray;
  }

  Eigen::Vector2d move(const TwoViewRecipe& r, int i) {
    double angle = r.direction_deg * CV_PI / 180;
    if (r.movers == Movers::Anyhow) angle = rng_.uniform(0, 2 * CV_PI);
    if (r.movers == Movers::TwoGroups && i % 2 == 0) angle += CV_PI / 2;
    const double length = r.movers == Movers::Expanding ? rng_.uniform(4, 12) : 6;
    return {length * std::cos(angle), length * std::sin(angle)};
  }

  void add(const Eigen::Vector2d& p, const Eigen::Vector2d& q, double noise) {
    auto jitter = [&](double x) { return static_cast<float>(x + (noise > 0 ? noise * rng_.normal() : 0)); };
    reference.emplace_back(jitter(p.x()), jitter(p.y()));
    current.emplace_back(jitter(q.x()), jitter(q.y()));
  }

  dynfilter::SampleGenerator rng_;
};

}  // namespace geometry_test
