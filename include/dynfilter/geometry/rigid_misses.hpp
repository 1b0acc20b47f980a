// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstddef>
#include <dynfilter/core/camera.hpp>
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

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/geometry/detail/rigid_misses-inl.hpp>
#endif
