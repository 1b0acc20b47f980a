// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/pose.hpp>
#include <opencv2/core.hpp>

namespace dynfilter {

/// How far the surfaces in the patch of a feature are apart in depth.
///
/// A patch over an occluding edge shows two surfaces, and its flow may be that of either. Where their edges
/// cross, it is neither: the crossing slides along both. On a plane the inverse depth is linear in the image,
/// so for pixels a and b at equal distances on both sides of c
///   1/Z_a + 1/Z_b - 2/Z_c = 0.
/// The relief is the largest absolute value of this sum over four directions and two distances. Between two
/// planes parallel to the image it is the difference of their inverse depths.
class PatchRelief {
 public:
  static constexpr int kNear_px = 4, kFar_px = 8;  ///< distances: a quarter and half of the flow's window

  /// `depth`: CV_32FC1 or CV_16UC1, not copied. Any other type has no relief anywhere.
  PatchRelief(const cv::Mat& depth, double unit_m);

  /// Relief [1/m] of the patch around a pixel with the depth `depth_m`, which has the noise `sigma_m`.
  /// 0 where it is within the noise, and where depths are missing. Reads 16 pixels.
  double per_m(const cv::Point2f& px, double depth_m, double sigma_m) const;

 private:
  static constexpr double kSigmas = 3;  ///< a plane exceeds them in one of 370 sums
  static constexpr double kTerms2 = 6;  ///< 1 + 1 + 4: squared factors of the three inverse depths
  double depth_at(int x, int y) const;

  cv::Mat depth_;
  double unit_m_;
};

/// How far a static point at `px` (undistorted, current frame) shifts in the image under the motion when its
/// inverse depth changes by `relief_per_m`: f |t_xy - x t_z| relief, to first order [px].
double relief_shift_px(const Camera& camera, const Pose& T_current_reference, const cv::Point2f& px,
                       double relief_per_m);

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/motion/detail/patch_relief-inl.hpp>
#endif
