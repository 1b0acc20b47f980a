// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/geometry/rigid_residual.hpp>
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
  StaticMissModel(const Camera& camera, const Pose& T_current_reference, const RigidResidualNoise& noise)
      : camera_(camera),
        noise_(noise),
        forward_(T_current_reference),
        backward_(inverse(T_current_reference)),
        space_(camera, T_current_reference, noise) {}

  StaticMiss operator()(const SeenPoint& then, const SeenPoint& now, const MatchSpread& spread = {}) const;
  /// The same without chi2 where both depths are known.
  StaticMiss miss(const SeenPoint& then, const SeenPoint& now) const;

 private:
  static constexpr double kNearest_m = 0.5;  ///< nothing is nearer to a camera
  static constexpr double kInFront_m = 1e-3;

  StaticMiss in_space(const SeenPoint& then, const SeenPoint& now, const MatchSpread& spread) const;
  StaticMiss of(const RigidResidual& r, const SeenPoint& now) const;

  StaticMiss in_image(const Pose& T, const SeenPoint& from, const SeenPoint& to,
                      const MatchSpread& spread) const;

  StaticMiss off_line(const SeenPoint& then, const SeenPoint& now, const MatchSpread& spread) const;
  static constexpr double kFar_m = 1000;  ///< of a point that the motion does not shift

  StaticMiss result(StaticMiss::Axes axes, const Eigen::Vector2d& r, double chi2, double depth_m) const;

  Eigen::Vector3d bearing(const cv::Point2f& px) const;
  static Eigen::Vector2d pixel(const cv::Point2f& px) { return {px.x, px.y}; }
  Eigen::Vector2d pixel(const Eigen::Vector3d& q) const;

  Camera camera_;
  RigidResidualNoise noise_;
  Pose forward_, backward_;
  RigidResidualModel space_;
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/motion/detail/static_miss-inl.hpp>
#endif
