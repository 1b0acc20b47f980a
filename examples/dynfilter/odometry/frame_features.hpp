// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/span.hpp>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <vector>

#include "descriptor.hpp"
#include "options.hpp"

namespace dynfilter::odometry {

/// Features of one frame in parallel arrays, which are compacted together.
struct FrameFeatures {
  std::vector<cv::KeyPoint> keypoints;  ///< pixels of the original image
  std::vector<cv::KeyPoint> keypoints_undistorted;
  std::vector<Descriptor> descriptors;
  std::vector<float> depth_m;           ///< NaN: no depth, or at a silhouette
  std::vector<float> right_u_px;        ///< stereo: column in the right image, NaN: no match; else empty
  std::vector<std::int64_t> map_point;  ///< -1: no map point
  std::vector<std::int32_t> extracted;  ///< index among the extracted features
  std::vector<MatchSpread> spread;      ///< how far each may have slid along its edge

  std::size_t size() const { return keypoints.size(); }

  void compact(Span<const std::uint8_t> rejected) {
    if (rejected.size() != size()) return;
    compact_array(keypoints, rejected);
    compact_array(keypoints_undistorted, rejected);
    compact_array(descriptors, rejected);
    compact_array(depth_m, rejected);
    if (!right_u_px.empty()) compact_array(right_u_px, rejected);
    compact_array(map_point, rejected);
    compact_array(extracted, rejected);
    compact_array(spread, rejected);
  }

 private:
  template <class T>
  static void compact_array(std::vector<T>& values, Span<const std::uint8_t> rejected) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < values.size(); ++i)
      if (!rejected[i]) values[kept++] = values[i];
    values.resize(kept);
  }
};

/// Pixels of an ideal pinhole camera with the same fx, fy, cx, cy.
inline void undistort(const Camera& camera, const std::vector<cv::KeyPoint>& distorted,
                      std::vector<cv::KeyPoint>& undistorted) {
  undistorted = distorted;
  if (!camera.distorted() || distorted.empty()) return;
  std::vector<cv::Point2f> points;
  cv::KeyPoint::convert(distorted, points);
  const cv::Matx33d K(camera.fx_px, 0, camera.cx_px, 0, camera.fy_px, camera.cy_px, 0, 0, 1);
  const cv::Mat coefficients(1, 5, CV_64F, const_cast<double*>(camera.distortion.data()));
  const cv::TermCriteria enough(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 20, 1e-4);
  cv::undistortPoints(points, points, K, coefficients, cv::noArray(), K, enough);
  for (std::size_t i = 0; i < points.size(); ++i) undistorted[i].pt = points[i];
}

inline double square(double x) {
  return x * x;
}

/// Depth [m] at a pixel of the original image: the median of its 3x3 neighbourhood.
/// NaN without depth, and near a depth jump, where it may belong to either side.
template <class T>
float depth_at(const cv::Mat& depth, double unit_m, cv::Point2f at, const DepthOptions& options) {
  constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
  const int x = cvRound(at.x), y = cvRound(at.y), reach = options.edge_radius_px;
  if (x < reach || y < reach || x >= depth.cols - reach || y >= depth.rows - reach) return kNone;
  const T centre = depth.at<T>(y, x);
  if (!(centre > 0)) return kNone;
  T nearest = centre, farthest = centre, inner[9];
  int count = 0;
  for (int v = y - reach; v <= y + reach; ++v) {
    const T* row = depth.ptr<T>(v);
    for (int u = x - reach; u <= x + reach; ++u) {
      if (!(row[u] > 0)) continue;
      nearest = std::min(nearest, row[u]);
      farthest = std::max(farthest, row[u]);
      if (std::abs(u - x) <= 1 && std::abs(v - y) <= 1) inner[count++] = row[u];
    }
  }
  const double limit_m =
      options.edge_ratio * centre * unit_m + options.edge_noise_per_m * square(centre * unit_m);
  if ((farthest - nearest) * unit_m > limit_m) return kNone;
  std::nth_element(inner, inner + count / 2, inner + count);
  const double depth_m = inner[count / 2] * unit_m;
  return depth_m <= options.max_m ? static_cast<float>(depth_m) : kNone;
}

inline void sample_depth(const cv::Mat& depth, double unit_m, const DepthOptions& options,
                         const std::vector<cv::KeyPoint>& keypoints, std::vector<float>& depth_m) {
  depth_m.assign(keypoints.size(), std::numeric_limits<float>::quiet_NaN());
  for (std::size_t i = 0; i < keypoints.size() && !depth.empty(); ++i)
    depth_m[i] = depth.type() == CV_16UC1 ? depth_at<std::uint16_t>(depth, unit_m, keypoints[i].pt, options)
                                          : depth_at<float>(depth, unit_m, keypoints[i].pt, options);
}

}  // namespace dynfilter::odometry
