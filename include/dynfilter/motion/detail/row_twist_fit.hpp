// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/cpu.hpp>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/core/simd.hpp>
#include <dynfilter/geometry/rigid_least_squares.hpp>
#include <dynfilter/geometry/small_matrix.hpp>
#include <dynfilter/geometry/undistort.hpp>
#include <dynfilter/motion/detail/background_points.hpp>
#include <dynfilter/motion/row_twist.hpp>

namespace dynfilter::detail {

/// A rigid motion and the twist of the rows at once: reweighted Gauss-Newton in nine unknowns. The twist is
/// expected to be short. With h the moved and twisted point and g the derivative of a residual by h,
///   J = [g, h x g, -s (h x g)].
/// Cost: six iterations over the points.
struct RowTwistFit {
  static constexpr int kIterations = 6;
  static constexpr double kWide_px = 0.7;  ///< noise assumed at first, halfway to the measured one each time
  static constexpr float kScale2 = 3;      ///< of the Cauchy weights: residuals in standard deviations
  static constexpr float kExplained2 = 9;  ///< three standard deviations
  static constexpr float kDepthWeight = 0.1F;  ///< depth is not taken at the time of a row

  bool ok = false;
  Pose T;
  RowTwist twist;
  double share = 0;                                         ///< of the points that both explain
  Eigen::Vector3d variance_rad2 = Eigen::Vector3d::Zero();  ///< of the twist, with the prior

  /// `noise_px`: of a match. A blurred frame's own noise would explain too much.
  static RowTwistFit of(const BackgroundPoints& points, const Camera& camera, const Pose& start,
                        double twist_sigma_rad, double noise_px) {
    RowTwistFit fit;
    fit.T = start;
    Normal normal;
    const double per_prior2 = 1 / (twist_sigma_rad * twist_sigma_rad);
    noise_px = std::min(kWide_px, noise_px);
    double sigma_px = kWide_px;
    for (int k = 0; k < kIterations; ++k) {
      double step[9];
      fit.linearise(points, camera, sigma_px, normal, step);
      for (int a = 0; a < 3; ++a) {
        normal[10 * (6 + a)] += per_prior2;
        step[6 + a] += -per_prior2 * fit.twist.a_rad[a];
      }
      Normal used;
      std::copy(normal, normal + 81, used);
      if (!solve_positive_definite(used, step, 9) || !all_finite(step, 9)) return fit;
      fit.T = Pose::from(exp_so3({step[3], step[4], step[5]}), {step[0], step[1], step[2]}) * fit.T;
      fit.twist.a_rad += Eigen::Vector3d(step[6], step[7], step[8]);
      const bool small = std::all_of(step + 3, step + 9,
                                     [](double turn_rad) { return std::abs(turn_rad) < kGoodEnough_rad; });
      if (sigma_px < kGoodEnough * noise_px && small) break;
      sigma_px = k + 2 < kIterations ? (sigma_px + noise_px) / 2 : noise_px;
    }
    Normal covariance;
    if (!invert_positive_definite(normal, covariance, 9)) return fit;
    fit.variance_rad2 = {covariance[60], covariance[70], covariance[80]};
    fit.ok = true;
    return fit;
  }

 private:
  using Normal = double[81];
  static constexpr double kGoodEnough = 1.5, kGoodEnough_rad = 2e-5;  ///< a hundredth of a pixel

  /// J^T W J and -J^T W r. The twist's columns of J are those of the turn times -s.
  void linearise(const BackgroundPoints& points, const Camera& camera, double sigma_px, Normal& normal,
                 double (&step)[9]) {
    const auto f = [&](double f_px) { return static_cast<float>(f_px / sigma_px); };
    double totals[3][RigidSums<Pack>::kCount];
    call_widest([&](auto lanes) DYNFILTER_AS_CALLER {
      sum_up<PackOf<lanes()>>(points, f(camera.fx_px), f(camera.fy_px), totals);
    });
    RigidNormal times_s[3];  // to the powers 0, 1, 2
    for (int k = 0; k < 3; ++k) times_s[k] = RigidSums<Pack>::normal_of(totals[k]);
    const auto column = [](int i) { return static_cast<std::size_t>(i < 6 ? i : i - 3); };
    for (int i = 0; i < 9; ++i) {
      const int twisted = i < 6 ? 0 : 1;
      step[i] = -times_s[twisted].gradient[column(i)];
      for (int j = 0; j <= i; ++j)
        normal[9 * i + j] = normal[9 * j + i] =
            times_s[twisted + (j < 6 ? 0 : 1)].matrix[6 * column(i) + column(j)];
    }
  }
  template <class P>
  DYNFILTER_AS_CALLER void sum_up(const BackgroundPoints& points, float fx, float fy,
                                  double (&totals)[3][RigidSums<Pack>::kCount]) {
    RigidSums<P> sums[3];
    P inside = 0, all = 0;
    const PointMotion motion(T);
    const auto& R = motion.R;
    const float a[3] = {static_cast<float>(twist.a_rad[0]), static_cast<float>(twist.a_rad[1]),
                        static_cast<float>(twist.a_rad[2])};
    points.for_each_pack<P>([&](const BackgroundPoints::PointPack<P>& k) DYNFILTER_AS_CALLER {
      P q[3];
      for (int r = 0; r < 3; ++r)
        q[r] = R[r][0] * k.p[0] + (R[r][1] * k.p[1] + R[r][2] * k.p[2]) + motion.t[r];
      const P h[3] = {q[0] - k.s * (a[1] * q[2] - a[2] * q[1]), q[1] - k.s * (a[2] * q[0] - a[0] * q[2]),
                      q[2] - k.s * (a[0] * q[1] - a[1] * q[0])};
      const P per_z = 1.0F / max(h[2], 1e-3F), u = h[0] * per_z, v = h[1] * per_z,
              wz = kDepthWeight / sqrt(k.depth_m2);
      const P r[3] = {fx * (u - k.u), fy * (v - k.v), wz * (h[2] - k.z)};
      const P chi2 = r[0] * r[0] + r[1] * r[1] + r[2] * r[2], near = 1.0F / (1.0F + chi2 * (1 / kScale2));
      inside += k.weight * above(P(kExplained2), chi2), all += k.weight;
      const P A[5] = {fx * per_z, -(fx * per_z * u), fy * per_z, -(fy * per_z * v), wz};
      P w = k.weight * above(h[2], 1e-3F) * near * near;
      for (RigidSums<P>& to : sums) {
        to.add(h, A, r, w);
        w *= -k.s;
      }
    });
    share = static_cast<double>(inside.sum() / std::max(1.0F, all.sum()));
    for (int k = 0; k < 3; ++k) sums[k].totals(totals[k]);
  }
};

}  // namespace dynfilter::detail
