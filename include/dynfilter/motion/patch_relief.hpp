// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/portable_math.hpp>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/geometry/depth_sampler.hpp>
#include <opencv2/core.hpp>
#include <utility>

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
  PatchRelief(const cv::Mat& depth, double unit_m) : depth_(depth, unit_m) {}

  /// Relief [1/m] of the patch around a pixel with the depth `depth_m`, which has the noise `sigma_m`.
  /// 0 where it is within the noise, and where depths are missing. Reads 16 pixels.
  double per_m(const cv::Point2f& px, double depth_m, double sigma_m) const {
    const auto in_image = [](float at, int size) { return at >= 0 && at < static_cast<float>(size); };
    if (!valid_depth(depth_m) || !in_image(px.x, depth_.cols()) || !in_image(px.y, depth_.rows())) return 0;
    const int x = cvRound(px.x), y = cvRound(px.y);
    double most = 0;
    for (const int r : {kNear_px, kFar_px})
      for (const auto& [dx, dy] : {std::pair{r, 0}, {0, r}, {r, r}, {r, -r}}) {
        const double a_m = depth_.at(x - dx, y - dy), b_m = depth_.at(x + dx, y + dy);
        if (valid_depth(a_m) && valid_depth(b_m))
          most = std::max(most, std::abs(1 / a_m + 1 / b_m - 2 / depth_m));
      }
    const double noise_per_m = std::sqrt(kTerms2) * sigma_m / (depth_m * depth_m);
    return most > kSigmas * noise_per_m ? most : 0;
  }

 private:
  static constexpr double kSigmas = 3;  ///< a plane exceeds them in one of 370 sums
  static constexpr double kTerms2 = 6;  ///< 1 + 1 + 4: squared factors of the three inverse depths

  DepthImage depth_;
};

/// Shift in the image [px] of a static point at `px` (undistorted, current frame) when its inverse depth
/// changes by `relief_per_m`. To first order it is f |t_xy - x t_z| relief.
inline double relief_shift_px(const Camera& camera, const Pose& T_current_reference, const cv::Point2f& px,
                              double relief_per_m) {
  const auto t = T_current_reference.t();
  const double u = t.x() - (px.x - camera.cx_px) / camera.fx_px * t.z(),
               v = t.y() - (px.y - camera.cy_px) / camera.fy_px * t.z();
  return portable::hypot(camera.fx_px * u, camera.fy_px * v) * relief_per_m;
}

}  // namespace dynfilter
