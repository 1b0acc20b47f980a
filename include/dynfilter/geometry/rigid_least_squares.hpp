// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstddef>
#include <dynfilter/core/cpu.hpp>
#include <dynfilter/core/simd.hpp>
#include <dynfilter/geometry/detail/rigid_points.hpp>
#include <dynfilter/geometry/small_matrix.hpp>

namespace dynfilter {

namespace detail {

/// Normal equations of the left perturbation (translation, rotation), summed over packs of points.
struct RigidNormal {
  std::array<double, 36> matrix{};   ///< J^T W J
  std::array<double, 6> gradient{};  ///< J^T W r
  double cost = 0;                   ///< sum w chi2
  double weight_sum = 0;
};

/// Lane-by-lane sums for RigidNormal, and their totals in the order kTT ... kWeight.
template <class P>
struct RigidSums {
  enum { kTT = 0, kTR = 5, kRR = 14, kGT = 20, kGR = 23, kCost = 26, kWeight = 27, kCount = 28 };
  P sum[kCount];

  DYNFILTER_AS_CALLER RigidSums() {
    for (P& s : sum) s = 0;
  }

  /// Adds points q with residual r. J = A [I | -[q]x] with A = d residual / d q.
  /// All sums follow from M = A^T A and f = A^T r. The rows of A are (A0 0 A1), (0 A2 A3), (0 0 A4).
  DYNFILTER_AS_CALLER void add(const P (&q)[3], const P (&A)[5], const P (&r)[3], const P& w) {
    const P &x = q[0], &y = q[1], &z = q[2];
    const P wa = w * A[0], wb = w * A[2];
    const P m00 = wa * A[0], m02 = wa * A[1], m11 = wb * A[2], m12 = wb * A[3];
    const P m22 = w * (A[1] * A[1] + A[3] * A[3] + A[4] * A[4]);
    sum[kTT] += m00, sum[kTT + 1] += m02, sum[kTT + 2] += m11, sum[kTT + 3] += m12, sum[kTT + 4] += m22;
    // N = -M [q]x, [q]x = (0 -z y; z 0 -x; -y x 0)
    const P n[9] = {m02 * y,           m00 * z - m02 * x, -m00 * y,  //
                    m12 * y - m11 * z, -m12 * x,          m11 * x,   //
                    m22 * y - m12 * z, m02 * z - m22 * x, m12 * x - m02 * y};
    for (int k = 0; k < 9; ++k) sum[kTR + k] += n[k];
    // [q]x N, upper triangle
    sum[kRR] += y * n[6] - z * n[3], sum[kRR + 1] += y * n[7] - z * n[4], sum[kRR + 2] += y * n[8] - z * n[5];
    sum[kRR + 3] += z * n[1] - x * n[7], sum[kRR + 4] += z * n[2] - x * n[8],
        sum[kRR + 5] += x * n[5] - y * n[2];
    const P fx = wa * r[0], fy = wb * r[1], fz = w * (A[1] * r[0] + A[3] * r[1] + A[4] * r[2]);
    sum[kGT] += fx, sum[kGT + 1] += fy, sum[kGT + 2] += fz;
    sum[kGR] += y * fz - z * fy, sum[kGR + 1] += z * fx - x * fz, sum[kGR + 2] += x * fy - y * fx;
    sum[kCost] += w * (r[0] * r[0] + r[1] * r[1] + r[2] * r[2]);
    sum[kWeight] += w;
  }

  DYNFILTER_AS_CALLER void totals(double (&s)[kCount]) const {
    for (int k = 0; k < kCount; ++k) s[k] = sum[k].sum();
  }
  static RigidNormal normal_of(const double (&s)[kCount]) {
    const double *tr = s + kTR, *rr = s + kRR;
    return {{s[0],  0,     s[1],  tr[0], tr[1], tr[2],  //
             0,     s[2],  s[3],  tr[3], tr[4], tr[5],  //
             s[1],  s[3],  s[4],  tr[6], tr[7], tr[8],  //
             tr[0], tr[3], tr[6], rr[0], rr[1], rr[2],  //
             tr[1], tr[4], tr[7], rr[1], rr[3], rr[4],  //
             tr[2], tr[5], tr[8], rr[2], rr[4], rr[5]},
            {s[kGT], s[kGT + 1], s[kGT + 2], s[kGR], s[kGR + 1], s[kGR + 2]},
            s[kCost],
            s[kWeight]};
  }
};

/// Adds the points of the pack from i, moved by the row-major `m`.
template <class P>
DYNFILTER_AS_CALLER inline void add_points(const RigidPoints& points, float scale2, const float (&m)[12],
                                           std::size_t i, RigidSums<P>& sums) {
  const auto get = [&](int r) DYNFILTER_AS_CALLER { return points.pack_of<P>(r, i); };
  const P px = get(RigidPoints::kPx), py = get(RigidPoints::kPy), pz = get(RigidPoints::kPz);
  const P cz = get(RigidPoints::kCz), wz = get(RigidPoints::kWz);
  const P q[3] = {m[0] * px + m[1] * py + m[2] * pz + m[3], m[4] * px + m[5] * py + m[6] * pz + m[7],
                  m[8] * px + m[9] * py + m[10] * pz + m[11]};
  // Padding has no weight, and what is behind the camera no residual.
  const P valid = above(wz, 0) * above(q[2], 1e-3F), inv_z = 1.0F / max(q[2], 1e-3F);
  const P u = q[0] * inv_z, v = q[1] * inv_z;
  P wx = get(RigidPoints::kWx) * cz, wy = get(RigidPoints::kWy) * cz;  // in units of f / sigma
  const P r[3] = {wx * (u - get(RigidPoints::kAx)), wy * (v - get(RigidPoints::kAy)), wz * (q[2] - cz)};
  wx *= inv_z, wy *= inv_z;
  // Tukey's rho'(s), the weight of iteratively reweighted least squares.
  const P inside = max(1.0F - (r[0] * r[0] + r[1] * r[1] + r[2] * r[2]) * (1 / scale2), 0);
  const P w = valid * (inside * inside);
  sums.add(q, {wx, -wx * u, wy, -wy * v, wz}, r, w);
}

/// Sums over the first `count` points in spread order.
inline RigidNormal accumulate_rigid(const RigidPoints& points, double scale2, std::size_t count,
                                    const RigidTransform& T) {
  float m[12];
  RigidPoints::to_float(T, m);
  const std::size_t end = std::min(count, points.count);
  double totals[RigidSums<Pack>::kCount];
  call_widest(
      [&](auto lanes) DYNFILTER_AS_CALLER {
        RigidSums<PackOf<lanes()>> sums;
        for (std::size_t i = 0; i < end; i += RigidPoints::kPack)
          add_points(points, static_cast<float>(scale2), m, i, sums);
        sums.totals(totals);
      },
      points.wide);
  return RigidSums<Pack>::normal_of(totals);
}

/// Iteratively reweighted Gauss-Newton on SE(3) over the first `count` points, 6x6 normal equations.
/// Leaves the equations of the last linearisation in `normal`. Ends before the last iteration where a step is
/// shorter than `until_sigmas` of its own standard deviations.
inline void refine_rigid(const RigidPoints& points, double scale, int iterations, double until_sigmas,
                         std::size_t count, RigidTransform& T, RigidNormal& normal) {
  normal = RigidSums<Pack>::normal_of({});
  for (int i = 0; i < iterations; ++i) {
    normal = accumulate_rigid(points, scale * scale, count, T);
    std::array<double, 36> matrix = normal.matrix;
    std::array<double, 6> delta;
    std::transform(normal.gradient.begin(), normal.gradient.end(), delta.begin(), std::negate<>());
    if (!(normal.weight_sum >= 2.5) || !solve_positive_definite(matrix.data(), delta.data(), 6)) return;
    if (!all_finite(delta.data(), 6)) return;
    const Eigen::Matrix3d turn = exp_so3({delta[3], delta[4], delta[5]});
    T.R = times(turn, T.R);
    T.t = turn * T.t + Eigen::Vector3d(delta[0], delta[1], delta[2]);
    double length2 = 0, gain = 0;
    for (std::size_t k = 0; k < 6; ++k) length2 += delta[k] * delta[k], gain -= normal.gradient[k] * delta[k];
    if (length2 < 1e-18 || gain < until_sigmas * until_sigmas) return;
  }
}

}  // namespace detail
}  // namespace dynfilter
