// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/geometry/rigid_misses.hpp>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/inline.hpp>
#include <dynfilter/core/order_statistics.hpp>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/core/span.hpp>
#include <dynfilter/geometry/depth_noise.hpp>
#include <opencv2/core.hpp>

namespace dynfilter {

DYNFILTER_INLINE void RigidMisses::measure(const Camera& camera, const Pose& T_current_reference,
                                           const RigidMatches& matches, Span<const int> points) {
  const Eigen::Matrix3d R = T_current_reference.R();
  const Eigen::Vector3d t = T_current_reference.t();
  const DepthNoise& sensor = matches.depth_noise;
  misses_.clear();
  depth_misses_.clear();
  for (const int i : points) {
    const auto k = static_cast<std::size_t>(i);
    const cv::Point3f &p = matches.reference_m[k], &c = matches.current_m[k];
    const Eigen::Vector3d q = R * Eigen::Vector3d(p.x, p.y, p.z) + t;
    const double x_px = camera.fx_px * (c.x / c.z - q.x() / q.z()),
                 y_px = camera.fy_px * (c.y / c.z - q.y() / q.z());
    misses_.push_back({matches.pixels[k], c.z, {static_cast<float>(x_px), static_cast<float>(y_px)}, 1});
    if (!(norm(x_px, y_px) < kReach_px)) continue;
    const double then_m = sensor.sigma_m(p.z), now_m = sensor.sigma_m(c.z);
    depth_misses_.push_back(static_cast<float>(std::abs(q.z() - c.z) / norm(then_m, now_m)));
  }
  constexpr double kMedianOfSigma = 0.6745;
  depth_factor_ = depth_misses_.size() < kMinPoints
                      ? 1
                      : std::clamp(median_in_place(depth_misses_) / kMedianOfSigma, 1.0, kMostDepthFactor);
}

}  // namespace dynfilter
