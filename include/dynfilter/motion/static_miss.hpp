// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/geometry/depth_noise.hpp>
#include <dynfilter/geometry/rigid_residual.hpp>
#include <dynfilter/geometry/undistort.hpp>
#include <limits>
#include <opencv2/core.hpp>

namespace dynfilter {

/// A feature in one frame.
struct SeenPoint {
  cv::Point2f px;                                           ///< undistorted
  float depth_m = std::numeric_limits<float>::quiet_NaN();  ///< NaN: not known
};

/// How far a match is from that of a static point, by as many coordinates as its depths determine.
struct StaticMiss {
  /// Which axes of the miss are compared.
  enum class Axes {
    None,   ///< says nothing
    Line,   ///< no depth: the distance from where the ray may lie in the other image
    Image,  ///< a depth in one frame: both coordinates of the other image
    Space   ///< depths in both frames: the image and the depth
  };
  Axes axes = Axes::None;
  cv::Point2f miss_px;                                       ///< measured minus predicted, undistorted pixels
  float image_px = std::numeric_limits<float>::quiet_NaN();  ///< its length
  float chi2 = std::numeric_limits<float>::quiet_NaN();      ///< normalised, of as many axes
  float px_per_m = std::numeric_limits<float>::quiet_NaN();  ///< focal length over depth, where the miss is
};

/// Misses of static points under a known motion q = R p + t.
///
/// Space: RigidResidualModel. Image: the point is put into the other frame;
///   chi2 = r^T S^-1 r, S = S_m + g g^T, g = d(u, v)/dz sigma_z(z), S_m of the match (core/frame_view.hpp),
/// with the frame whose depth is known as the one that predicts. Line: the ray of the reference feature has
/// the image points pi(R x + rho t), with the inverse depth rho in [0, 1 / kNearest_m]. The nearest of them
/// is triangulated linearly; chi2 is the squared distance from it over S_m's variance in that direction. Far
/// points do not move with t, so their whole miss counts.
class StaticMissModel {
 public:
  /// Of points in the reference camera, seen by the current one.
  StaticMissModel(const Camera& camera, const Pose& T_current_reference, const RigidResidualNoise& noise)
      : camera_(camera),
        noise_(noise),
        forward_(T_current_reference),
        backward_(inverse(T_current_reference)),
        space_(camera, T_current_reference, noise) {}

  static constexpr double kNearest_m = 0.5;  ///< nothing is nearer to a camera

  StaticMiss operator()(const SeenPoint& then, const SeenPoint& now, const MatchSpread& spread = {}) const;
  /// The same without chi2 where both depths are known.
  StaticMiss miss(const SeenPoint& then, const SeenPoint& now) const {
    if (!valid_depth(then.depth_m) || !valid_depth(now.depth_m)) return operator()(then, now);
    return of(
        space_.miss(back_project(camera_, then.px, then.depth_m), back_project(camera_, now.px, now.depth_m)),
        now);
  }

 private:
  static constexpr double kInFront_m = 1e-3;

  StaticMiss in_space(const SeenPoint& then, const SeenPoint& now, const MatchSpread& spread) const {
    return of(space_(back_project(camera_, then.px, then.depth_m), back_project(camera_, now.px, now.depth_m),
                     spread),
              now);
  }
  StaticMiss of(const RigidResidual& r, const SeenPoint& now) const {
    StaticMiss out;
    if (!r.valid) return out;
    out.axes = StaticMiss::Axes::Space;
    out.miss_px = now.px - r.predicted_px;
    out.image_px = r.image_px;
    out.chi2 = r.chi2;
    out.px_per_m = static_cast<float>(camera_.fx_px) / now.depth_m;
    return out;
  }

  StaticMiss in_image(const Pose& T, const SeenPoint& from, const SeenPoint& to,
                      const MatchSpread& spread) const {
    StaticMiss out;
    const Eigen::Vector3d ray = T.R() * bearing(from.px);
    const double z_m = from.depth_m;
    const Eigen::Vector3d q = T.t() + z_m * ray;
    if (!(q.z() > kInFront_m)) return out;
    const Eigen::Vector2d r = pixel(to.px) - pixel(q);
    // d(u, v)/dz of the point along its ray.
    const double sigma_m = noise_.depth_noise.sigma_m(z_m) / q.z();
    const Eigen::Vector2d g(camera_.fx_px * sigma_m * (ray.x() - q.x() / q.z() * ray.z()),
                            camera_.fy_px * sigma_m * (ray.y() - q.y() / q.z() * ray.z()));
    const double s2 = noise_.pixel_sigma_px * noise_.pixel_sigma_px * spread.across;
    const Eigen::Vector2d e(spread.edge.x, spread.edge.y);
    const double explained =
        1 - spread.across / static_cast<double>(spread.along);  // of the part along the edge
    const auto dot = [&](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
      return (a.dot(b) - explained * a.dot(e) * b.dot(e)) / s2;
    };
    const double rg = dot(r, g);
    return result(StaticMiss::Axes::Image, r, dot(r, r) - rg * rg / (1 + dot(g, g)), q.z());
  }

  StaticMiss off_line(const SeenPoint& then, const SeenPoint& now, const MatchSpread& spread) const {
    const Eigen::Vector3d a = forward_.R() * bearing(then.px), t = forward_.t();
    const Eigen::Vector3d b = bearing(now.px);
    // (a_x + rho t_x) - b_x (a_z + rho t_z) = 0, and the same for y.
    const Eigen::Vector2d c(a.x() - b.x() * a.z(), a.y() - b.y() * a.z()),
        d(t.x() - b.x() * t.z(), t.y() - b.y() * t.z());
    const double d2 = d.squaredNorm();
    const double per_m = d2 > 0 ? std::clamp(-c.dot(d) / d2, 0.0, 1 / kNearest_m) : 0;
    const Eigen::Vector3d q = a + per_m * t;
    if (!(q.z() > kInFront_m)) return {};
    const Eigen::Vector2d r = pixel(now.px) - pixel(q);
    const double r2 = r.squaredNorm(), along = r.x() * spread.edge.x + r.y() * spread.edge.y;
    const double s2 = noise_.pixel_sigma_px * noise_.pixel_sigma_px;
    const double variance_r2 = s2 * (spread.across * r2 + (spread.along - spread.across) * along * along);
    return result(StaticMiss::Axes::Line, r, r2 > 0 ? r2 * r2 / variance_r2 : 0,
                  per_m > 0 ? q.z() / per_m : kFar_m);
  }
  static constexpr double kFar_m = 1000;  ///< of a point that the motion does not shift

  StaticMiss result(StaticMiss::Axes axes, const Eigen::Vector2d& r, double chi2, double depth_m) const {
    StaticMiss out;
    if (!std::isfinite(chi2)) return out;
    out.axes = axes;
    out.miss_px = {static_cast<float>(r.x()), static_cast<float>(r.y())};
    out.image_px = static_cast<float>(r.norm());
    out.chi2 = static_cast<float>(chi2);
    out.px_per_m = static_cast<float>(camera_.fx_px / std::min(kFar_m, depth_m));
    return out;
  }

  Eigen::Vector3d bearing(const cv::Point2f& px) const {
    return {(px.x - camera_.cx_px) / camera_.fx_px, (px.y - camera_.cy_px) / camera_.fy_px, 1};
  }
  static Eigen::Vector2d pixel(const cv::Point2f& px) { return {px.x, px.y}; }
  Eigen::Vector2d pixel(const Eigen::Vector3d& q) const {
    return {camera_.fx_px * q.x() / q.z() + camera_.cx_px, camera_.fy_px * q.y() / q.z() + camera_.cy_px};
  }

  Camera camera_;
  RigidResidualNoise noise_;
  Pose forward_, backward_;
  RigidResidualModel space_;
};

inline StaticMiss StaticMissModel::operator()(const SeenPoint& then, const SeenPoint& now,
                                              const MatchSpread& spread) const {
  const bool then_known = valid_depth(then.depth_m), now_known = valid_depth(now.depth_m);
  if (then_known && now_known) return in_space(then, now, spread);
  if (then_known) return in_image(forward_, then, now, spread);
  if (now_known) return in_image(backward_, now, then, spread);
  return off_line(then, now, spread);
}

}  // namespace dynfilter
