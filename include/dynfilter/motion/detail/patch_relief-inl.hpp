// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/motion/patch_relief.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <dynfilter/core/inline.hpp>
#include <dynfilter/core/portable_math.hpp>
#include <dynfilter/geometry/depth_noise.hpp>
#include <opencv2/core.hpp>
#include <utility>

namespace dynfilter {

DYNFILTER_INLINE PatchRelief::PatchRelief(const cv::Mat& depth, double unit_m)
    : depth_(depth), unit_m_(unit_m) {
  if (depth.type() != CV_32FC1 && depth.type() != CV_16UC1) depth_ = cv::Mat();
}

DYNFILTER_INLINE double PatchRelief::per_m(const cv::Point2f& px, double depth_m, double sigma_m) const {
  const auto in_image = [](float at, int size) { return at >= 0 && at < static_cast<float>(size); };
  if (!valid_depth(depth_m) || !in_image(px.x, depth_.cols) || !in_image(px.y, depth_.rows)) return 0;
  const int x = cvRound(px.x), y = cvRound(px.y);
  double most = 0;
  for (const int r : {kNear_px, kFar_px})
    for (const auto& [dx, dy] : {std::pair{r, 0}, {0, r}, {r, r}, {r, -r}}) {
      const double a_m = depth_at(x - dx, y - dy), b_m = depth_at(x + dx, y + dy);
      if (valid_depth(a_m) && valid_depth(b_m))
        most = std::max(most, std::abs(1 / a_m + 1 / b_m - 2 / depth_m));
    }
  const double noise_per_m = std::sqrt(kTerms2) * sigma_m / (depth_m * depth_m);
  return most > kSigmas * noise_per_m ? most : 0;
}

inline double PatchRelief::depth_at(int x, int y) const {
  if (x < 0 || y < 0 || x >= depth_.cols || y >= depth_.rows) return 0;
  return depth_.type() == CV_16UC1 ? depth_.ptr<std::uint16_t>(y)[x] * unit_m_
                                   : static_cast<double>(depth_.ptr<float>(y)[x]);
}

DYNFILTER_INLINE double relief_shift_px(const Camera& camera, const Pose& T_current_reference,
                                        const cv::Point2f& px, double relief_per_m) {
  const auto t = T_current_reference.t();
  const double u = t.x() - (px.x - camera.cx_px) / camera.fx_px * t.z(),
               v = t.y() - (px.y - camera.cy_px) / camera.fy_px * t.z();
  return portable::hypot(camera.fx_px * u, camera.fy_px * v) * relief_per_m;
}

}  // namespace dynfilter
