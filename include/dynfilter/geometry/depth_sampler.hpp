// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <dynfilter/geometry/depth_noise.hpp>
#include <limits>
#include <opencv2/core.hpp>

namespace dynfilter {

/// `depth_m`, or NaN where it is invalid or beyond `max_depth_m`.
inline float depth_within(float depth_m, double max_depth_m) {
  return valid_depth(depth_m) && static_cast<double>(depth_m) <= max_depth_m
             ? depth_m
             : std::numeric_limits<float>::quiet_NaN();
}

/// Depth [m] at single pixels. NaN if the pixel has no reliable depth.
/// At a silhouette the sensor's depth may belong to either surface.
/// A pixel has no depth if neighbouring pixels differ by more than `max_edge_share` of the depth.
/// A hole takes the depth around it if that is one surface.
/// Structured light often leaves holes at corners, where features are detected.
class DepthSampler {
 public:
  static constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

  /// `depth`: CV_32FC1 or CV_16UC1. Any other type has no depth anywhere.
  DepthSampler(const cv::Mat& depth, double unit_m, double max_edge_share);

  float at(const cv::Point2f& px) const;

  /// Calls `take(i, depth)` for each pixel.
  /// Features are scattered in memory, so upcoming pixels are prefetched.
  template <class Pixels, class Take>
  void at_all(const Pixels& px, const Take& take) const {
    constexpr std::size_t kAhead = 8;
    for (std::size_t i = 0; i < px.size(); ++i) {
      if (i + kAhead < px.size()) fetch(px[i + kAhead]);
      take(i, at(px[i]));
    }
  }

 private:
  static constexpr int kEdgeRadiusPx = 2, kRingRadiusPx = 4;

  void fetch(const cv::Point2f& px) const;

  template <class T>
  float at_of(const cv::Point2f& px) const;

  template <class T, bool kInside>
  float at_pixel(int x, int y) const;

  template <class T, bool kInside>
  float unless_edge(int x, int y, float centre) const;

  /// The mean of the ring around a hole, if most of the ring has depth and agrees.
  template <class T, bool kInside>
  float from_around(int x, int y) const;

  template <class T, bool kInside>
  float read(int x0, int y0, int dx, int dy) const;

  cv::Mat depth_;
  float unit_m_, max_edge_share_;
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/geometry/detail/depth_sampler-inl.hpp>
#endif
