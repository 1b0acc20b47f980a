// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

namespace dynfilter {

/// Camera motion between two views up to scale: five degrees of freedom.
/// An approximate focal length is sufficient while the camera rotates by a few degrees.
struct ViewMotion {
  /// Axis times angle; rotates current rays to the reference view.
  std::array<double, 3> rotation_rad{};
  /// Of the current camera's centre, unit length; 0: no baseline.
  std::array<double, 3> direction{0, 0, 1};
  double focal_px = 1;

  bool has_baseline() const { return direction != std::array<double, 3>{}; }
};

/// A point in two views, in undistorted pixels relative to the principal point.
struct ViewPair {
  double reference_x = 0, reference_y = 0, x = 0, y = 0;
};

/// Flow of a point in the reference view after the camera's rotation is removed.
struct ViewFlow {
  double across_px = 0;  ///< distance from its epipolar line; without a baseline: flow to the right
  /// Flow along it, positive for static points; without a baseline: flow downwards.
  double along_px = 0;
  /// Length of the camera's step divided by the depth. 0 without a baseline.
  double inverse_depth = 0;

  double length_px() const { return std::sqrt(across_px * across_px + along_px * along_px); }
};

/// Splits flow into parts along and across the epipolar line of a motion.
/// q is the current point after the inverse rotation and a the reference point.
/// f is the focal length and c the direction.
/// A static point obeys q - a = mu (q c_z - f c_xy) with mu = step / depth >= 0.
/// This is the finite form of Longuet-Higgins and Prazdny (1980).
class ViewFlowModel {
 public:
  explicit ViewFlowModel(const ViewMotion& motion);

  ViewFlow operator()(const ViewPair& p) const {
    const double z = R_[6] * p.x + R_[7] * p.y + R_[8] * f_;
    if (!(z > 0.05 * f_)) return {1e3, 0, 0};  // rotated out of view
    const double scale = f_ / z, qx = scale * (R_[0] * p.x + R_[1] * p.y + R_[2] * f_),
                 qy = scale * (R_[3] * p.x + R_[4] * p.y + R_[5] * f_);
    const double ex = qx - p.reference_x, ey = qy - p.reference_y;
    if (!baseline_) return {ex, ey, 0};
    const double dx = qx * c_[2] - f_ * c_[0], dy = qy * c_[2] - f_ * c_[1];
    // + 1 px: lines are undefined near the focus of expansion.
    const double squared = dx * dx + dy * dy + 1;
    const double inverse = 1 / std::sqrt(squared), along = (ex * dx + ey * dy) * inverse;
    return {(ex * dy - ey * dx) * inverse, along, along * inverse};
  }

  /// Of the rotation, row by row.
  const std::array<double, 9>& matrix() const { return R_; }

 private:
  void rotation_matrix(const std::array<double, 3>& w);

  std::array<double, 9> R_{};
  std::array<double, 3> c_;
  double f_;
  bool baseline_;
};

namespace detail {

void normalise(std::array<double, 3>& v);

/// Two directions perpendicular to `c` and to each other.
std::array<std::array<double, 3>, 2> tangents(const std::array<double, 3>& c);

/// The motion after a small step: three components for the rotation, two for the direction.
ViewMotion stepped(const ViewMotion& motion, const double (&step)[5]);

/// Left Jacobian of SO(3).
/// Column k is the rotation after w caused by a step of component k.
std::array<std::array<double, 3>, 3> turns_by_step(const std::array<double, 3>& w);

}  // namespace detail

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/motion/detail/view_motion-inl.hpp>
#endif
