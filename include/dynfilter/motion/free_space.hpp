// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <dynfilter/core/portable_math.hpp>
#include <dynfilter/geometry/depth_noise.hpp>
#include <dynfilter/geometry/depth_sampler.hpp>
#include <dynfilter/geometry/undistort.hpp>
#include <limits>
#include <opencv2/core.hpp>
#include <optional>

namespace dynfilter {

/// The nearest depth [m] within `radius_px` of a pixel, in rows and columns. None if it is `beyond_m` or
/// nearer, if the window leaves the image, or if less than half of it has a depth.
inline std::optional<float> nearest_depth_m(const DepthImage& depth, const cv::Point2f& px, int radius_px,
                                            float beyond_m) {
  const auto inside = [&](float at, int size) {
    return at >= static_cast<float>(radius_px) && at <= static_cast<float>(size - 1 - radius_px);
  };
  if (!inside(px.x, depth.cols()) || !inside(px.y, depth.rows())) return std::nullopt;
  const int x = cvRound(px.x), y = cvRound(px.y), side = 2 * radius_px + 1;
  float nearest_m = std::numeric_limits<float>::infinity();
  int known = 0;
  for (int row = 0; row < side; ++row)  // from the middle: most windows hold the point's own surface
    for (int dx = -radius_px; dx <= radius_px; ++dx) {
      const float z_m = depth.at(x + dx, row % 2 == 0 ? y + row / 2 : y - (row + 1) / 2);
      if (!valid_depth(z_m)) continue;
      if (z_m <= beyond_m) return std::nullopt;
      nearest_m = std::min(nearest_m, z_m);
      ++known;
    }
  if (2 * known < side * side) return std::nullopt;
  return nearest_m;
}

/// Likelihood ratio [nats] that a surface was not where it is now: an earlier view looked through the place.
///
/// The point, put into the view by the background's motion, has the depth Z there. In the window of its
/// positional uncertainty the view's nearest depth is Z + d with d > 0. If the surface is static, d is an
/// error. It is Student t (nu = 6) with the depth noise s of both. For a share e of the features it is a
/// gross error.
/// If it moved, d is the distance to what is behind, anything up to R, for a share u of the movers:
///   odds = log(u / (R t(d / s) / s + e))
/// Below 0 nothing is said: a mover also hides its own earlier place, and an occluder hides any place.
/// The window's radius is three standard deviations of the match and of the depth's parallax, and 3 px for
/// silhouettes. Free space is evidence as in ReFusion (Palazzolo et al., IROS 2019) and DynaSLAM's multi-view
/// test (Bescos et al., RA-L 2018). About 0.1 us where something is there, 0.3 us else.
class FreeSpaceView {
 public:
  /// What is assumed of errors.
  struct Model {
    double sigma_px = 1;       ///< of the point's place in the view, per axis
    DepthNoise depth_noise{};  ///< of both depths
  };

  /// `depth`: of the earlier view, not copied. T_view_current: to that view's camera.
  FreeSpaceView(const Camera& camera, const cv::Mat& depth, double unit_m, const Pose& T_view_current,
                const Model& model)
      : camera_(camera),
        depth_(depth, unit_m),
        R_(T_view_current.R()),
        t_(T_view_current.t()),
        model_(model) {}

  /// Of a point in the current camera's frame [m]. 0: the view says nothing.
  double odds(const cv::Point3f& point_m) const {
    if (!valid_depth(point_m.z)) return 0;
    const Eigen::Vector3d far = R_ * Eigen::Vector3d(point_m.x, point_m.y, point_m.z), p = far + t_;
    if (!(p.z() > 0) || !(far.z() > 0)) return 0;
    const cv::Point2f px = pixel(p);
    const double here_m = model_.depth_noise.sigma_m(point_m.z);
    const cv::Point2f parallax_px = px - pixel(far);
    const double along_px = portable::hypot(parallax_px.x, parallax_px.y) * here_m / point_m.z;
    const double radius_px = kReach * portable::hypot(model_.sigma_px, along_px) + kSilhouette_px;
    if (!(radius_px <= kMostRadius_px)) return 0;
    const auto there_m =
        nearest_depth_m(depth_, px, static_cast<int>(std::ceil(radius_px)), static_cast<float>(p.z()));
    return there_m ? std::max(0.0, odds_of(*there_m - p.z(), here_m, *there_m)) : 0;
  }

 private:
  static constexpr double kReach = 3;           ///< standard deviations of a place
  static constexpr double kSilhouette_px = 3;   ///< depth cameras misplace an outline by as much
  static constexpr double kMostRadius_px = 20;  ///< a wider window is never free
  static constexpr double kRange_m = 4;         ///< what is behind a mover: the depth of a room
  static constexpr double kThrough = 0.5;       ///< share of movers whose place was free, measured
  static constexpr double kGross = 0.005;       ///< share of static features with a gross error, measured
  static constexpr double kNu = 6;              ///< tails, as of matches
  static constexpr double kPeak = 0.3827;       ///< t density with nu = 6 at 0

  cv::Point2f pixel(const Eigen::Vector3d& p) const {
    return distort_point(camera_, project(camera_, to_point(p)));
  }
  double odds_of(double behind_m, double here_m, double there_m) const {
    const double sigma_m = portable::hypot(here_m, model_.depth_noise.sigma_m(there_m)),
                 t = behind_m / sigma_m;
    const double error = kPeak * portable::power(1 + t * t / kNu, -(kNu + 1) / 2) / sigma_m;
    return portable::log(kThrough / (kRange_m * error + kGross));
  }

  Camera camera_;
  DepthImage depth_;
  Eigen::Matrix3d R_;
  Eigen::Vector3d t_;
  Model model_;
};

}  // namespace dynfilter
