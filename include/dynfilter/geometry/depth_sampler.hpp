// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <dynfilter/geometry/depth_noise.hpp>
#include <limits>
#include <opencv2/core.hpp>
#include <utility>

namespace dynfilter {

/// `depth_m`, or NaN where it is invalid or beyond `max_depth_m` [m].
inline float depth_within(float depth_m, double max_depth_m) {
  return valid_depth(depth_m) && static_cast<double>(depth_m) <= max_depth_m
             ? depth_m
             : std::numeric_limits<float>::quiet_NaN();
}

/// Depths of single pixels, whatever their type. DepthSampler has those of features.
class DepthImage {
 public:
  DepthImage() = default;
  /// `depth`: CV_32FC1 or CV_16UC1, not copied. Any other type has no depth anywhere.
  DepthImage(const cv::Mat& depth, double unit_m) : unit_m_(static_cast<float>(unit_m)) {
    if (depth.type() == CV_32FC1 || depth.type() == CV_16UC1) depth_ = depth;
  }

  bool empty() const { return depth_.empty(); }  ///< whether it has no pixels
  int cols() const { return depth_.cols; }       ///< width [px]
  int rows() const { return depth_.rows; }       ///< height [px]
  /// At a pixel [m]; 0 outside. May be invalid (valid_depth()).
  float at(int x, int y) const {
    if (x < 0 || y < 0 || x >= depth_.cols || y >= depth_.rows) return 0;
    return (depth_.type() == CV_16UC1 ? static_cast<float>(depth_.ptr<std::uint16_t>(y)[x])
                                      : depth_.ptr<float>(y)[x]) *
           unit_m_;
  }

 private:
  cv::Mat depth_;
  float unit_m_ = 1;
};

/// Depth [m] at single pixels. NaN if the pixel has no reliable depth. At a silhouette the sensor's depth may
/// belong to either surface. A pixel has no depth if neighbouring pixels differ by more than `max_edge_share`
/// of the depth. A hole takes the depth around it if that is one surface. Structured light often leaves holes
/// at corners, where features are detected.
class DepthSampler {
 public:
  /// Largest relative depth difference to neighbouring pixels; beyond it, a pixel has no depth.
  static constexpr double kMaxDepthEdge = 0.06;
  static constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

  /// `depth`: CV_32FC1 or CV_16UC1. Any other type has no depth anywhere.
  DepthSampler(const cv::Mat& depth, double unit_m, double max_edge_share)
      : depth_(depth),
        unit_m_(static_cast<float>(unit_m)),
        max_edge_share_(static_cast<float>(max_edge_share)) {
    if (depth.empty() || (depth.type() != CV_32FC1 && depth.type() != CV_16UC1)) depth_ = cv::Mat();
  }

  /// At a place [px]; kNone if there is none.
  float at(const cv::Point2f& px) const {
    return depth_.type() == CV_32FC1 ? at_of<float>(px) : at_of<std::uint16_t>(px);
  }

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

inline void DepthSampler::fetch(const cv::Point2f& px) const {
  if (!(px.x >= 0) || !(px.y >= kEdgeRadiusPx) || !(px.x < static_cast<float>(depth_.cols)) ||
      !(px.y < static_cast<float>(depth_.rows - kEdgeRadiusPx)))
    return;
  const std::size_t x = static_cast<std::size_t>(px.x) * depth_.elemSize();
  for (const int dy : {-kEdgeRadiusPx, 0, kEdgeRadiusPx})
    __builtin_prefetch(depth_.ptr(static_cast<int>(px.y) + dy) + x);
}

template <class T>
float DepthSampler::at_of(const cv::Point2f& px) const {
  if (depth_.data == nullptr || !(px.x >= -0.5F) || !(px.y >= -0.5F)) return kNone;
  if (!(px.x < static_cast<float>(depth_.cols)) || !(px.y < static_cast<float>(depth_.rows))) return kNone;
  const int x = std::min(cvRound(px.x), depth_.cols - 1), y = std::min(cvRound(px.y), depth_.rows - 1);
  const auto inside = [](int at, int size) {
    return at >= kRingRadiusPx && at < size - kRingRadiusPx;  // the ring needs no bounds checks
  };
  return inside(x, depth_.cols) && inside(y, depth_.rows) ? at_pixel<T, true>(x, y)
                                                          : at_pixel<T, false>(x, y);
}

template <class T, bool kInside>
float DepthSampler::at_pixel(int x, int y) const {
  const float centre = read<T, kInside>(x, y, 0, 0);
  return valid_depth(centre) ? unless_edge<T, kInside>(x, y, centre) : from_around<T, kInside>(x, y);
}

template <class T, bool kInside>
float DepthSampler::unless_edge(int x, int y, float centre) const {
  const float limit = max_edge_share_ * centre;
  bool edge = false;
  for (const auto& [dx, dy] : {std::pair{-1, 0}, {1, 0}, {0, -1}, {0, 1}}) {
    const float other = read<T, kInside>(x, y, dx * kEdgeRadiusPx, dy * kEdgeRadiusPx);
    edge = edge || (std::abs(other - centre) > limit && valid_depth(other));
  }
  return edge ? kNone : centre;
}

template <class T, bool kInside>
float DepthSampler::from_around(int x, int y) const {
  float sum = 0, nearest = std::numeric_limits<float>::infinity(), farthest = 0;
  int known = 0;
  constexpr std::pair<int, int> kRing[] = {{-2, 0}, {2, 0}, {0, -2}, {0, 2}, {-3, -3}, {3, -3},
                                           {-3, 3}, {3, 3}, {-4, 0}, {4, 0}, {0, -4},  {0, 4}};
  for (const auto& [dx, dy] : kRing) {
    const float z = read<T, kInside>(x, y, dx, dy);
    if (!valid_depth(z)) continue;
    sum += z;
    nearest = std::min(nearest, z);
    farthest = std::max(farthest, z);
    ++known;
  }
  if (known < 5 || farthest - nearest > 0.5F * max_edge_share_ * nearest) return kNone;
  return sum / static_cast<float>(known);
}

template <class T, bool kInside>
float DepthSampler::read(int x0, int y0, int dx, int dy) const {
  const int x = x0 + dx, y = y0 + dy;
  if (!kInside && (x < 0 || y < 0 || x >= depth_.cols || y >= depth_.rows)) return kNone;
  return static_cast<float>(depth_.ptr<T>(y)[x]) * unit_m_;
}

}  // namespace dynfilter
