// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/order_statistics.hpp>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/core/span.hpp>
#include <dynfilter/geometry/depth_noise.hpp>
#include <dynfilter/geometry/neighbour_noise.hpp>
#include <opencv2/core.hpp>
#include <vector>

namespace dynfilter {

/// Matched points of two frames. One entry per feature in every span.
struct RigidMatches {
  Span<const cv::Point3f> reference_m, current_m;  ///< in the camera frames
  Span<const cv::Point2f> pixels;                  ///< where the features are now
  DepthNoise depth_noise{};                        ///< of the sensor
};

/// What a rigid motion leaves of a frame's matches, in the image and in depth. Owns its scratch.
class RigidMisses {
 public:
  static constexpr double kMostDepthFactor = 10;

  /// `points` are indices of matches with depth in both frames.
  void measure(const Camera& camera, const Pose& T_current_reference, const RigidMatches& matches,
               Span<const int> points);

  /// Misses in the image, one per point, in px.
  const std::vector<Miss>& misses() const { return misses_; }
  /// Error of the depths in units of the sensor's model, within [1, kMostDepthFactor]: colour and depth are
  /// not taken at the same time. 1 with fewer than 30 points that the motion predicts within 3 px.
  double depth_factor() const { return depth_factor_; }

 private:
  static constexpr double kReach_px = 3;  ///< misses below this tell how exact the depths are
  static constexpr std::size_t kMinPoints = 30;

  static double norm(double x, double y) { return std::sqrt(x * x + y * y); }  // std::hypot is slow

  std::vector<Miss> misses_;
  std::vector<float> depth_misses_;
  double depth_factor_ = 1;
};

inline void RigidMisses::measure(const Camera& camera, const Pose& T_current_reference,
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
