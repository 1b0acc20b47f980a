// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cstddef>
#include <dynfilter/core/portable_math.hpp>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/core/simd.hpp>
#include <dynfilter/core/span.hpp>
#include <dynfilter/geometry/detail/two_view_points.hpp>
#include <dynfilter/geometry/epipolar_distance.hpp>
#include <dynfilter/geometry/small_matrix.hpp>
#include <limits>

namespace dynfilter::detail {

/// Derivatives of the nine entries of a matrix, row-major, by up to eight parameters.
using EntryDerivatives = std::array<Matrix9, 8>;

inline Eigen::Matrix3d diagonal(double a, double b) {
  Eigen::Matrix3d m = Eigen::Matrix3d::Zero();
  m(0, 0) = a;
  m(1, 1) = b;
  return m;
}

/// Normal equations in the nine entries of a matrix.
/// Each parametrisation p of that matrix with D = d entries/dp solves (D^T A D) dp = -D^T g.
/// In plain loops: as fixed-size Eigen expressions, the products need half a minute and 1.5 GB per file.
struct EntryNormal {
  std::array<Matrix9, 9> A;  ///< symmetric
  Matrix9 g;

  /// dp for the first `n` parameters.
  bool step(const EntryDerivatives& D, int n, std::array<double, 8>& delta) const {
    double normal[64];
    for (int c = 0; c < n; ++c) {
      const Matrix9& derivative = D[static_cast<std::size_t>(c)];
      Matrix9 column;
      for (std::size_t r = 0; r < 9; ++r) column[r] = dot(A[r], derivative);
      for (int r = 0; r < n; ++r) normal[c * n + r] = dot(D[static_cast<std::size_t>(r)], column);
      delta[static_cast<std::size_t>(c)] = -dot(derivative, g);
    }
    return solve_positive_definite(normal, delta.data(), n) && all_finite(delta.data(), n);
  }

 private:
  static double dot(const Matrix9& a, const Matrix9& b) {
    double sum = 0;
    for (std::size_t k = 0; k < 9; ++k) sum += a[k] * b[k];
    return sum;
  }
};

/// Matches used by a refinement: the first `count` in spread order.
/// If `errors` are given, only matches with `errors[i] <= limit`.
struct Selection {
  std::size_t count = std::numeric_limits<std::size_t>::max();
  const float* errors = nullptr;
  float limit = 0;
};

/// Zero for the matches of a pack that are not selected.
inline Pack selected(const TwoViewPoints& points, const Selection& selection, std::size_t i) {
  Pack mask = 1;
  for (int k = 0; k < Pack::kWidth; ++k) {
    const std::size_t match = i + static_cast<std::size_t>(k);
    const bool is =
        match < points.count() && (!selection.errors || selection.errors[match] <= selection.limit);
    if (!is) mask.set(k, 0);
  }
  return mask;
}

/// Index of the product of entries r and c of (x, y, 1) in xx, xy, yy, x, y, 1.
constexpr int kProduct[3][3] = {{0, 1, 3}, {1, 2, 4}, {3, 4, 5}};

/// Reweighted Sampson residuals a.f / sqrt(den), a = (u, v, 1) x (x, y, 1).
/// Tukey's weights end at `cut2` (squared, normalised units). Every entry of a a^T is one of 36 products.
inline bool accumulate_epipolar(const TwoViewPoints& points, const Eigen::Matrix3d& F, double cut2,
                                const Selection& selection, EntryNormal& normal) {
  float f[9];
  for (int i = 0; i < 9; ++i) f[i] = static_cast<float>(F(i / 3, i % 3));
  Pack A[6][6], g[3][3];
  for (auto& row : A) std::fill(row, row + 6, Pack(0));
  for (auto& row : g) std::fill(row, row + 3, Pack(0));
  const float inv_cut = static_cast<float>(1 / cut2);
  Eigen::Index used = 0;
  const std::size_t end = std::min(selection.count, points.count());
  for (std::size_t i = 0; i < end; i += Pack::kWidth) {
    const Pack x = points.x(i), y = points.y(i), u = points.u(i), v = points.v(i);
    const EpipolarTerms<Pack> terms(f, x, y, u, v);
    const Pack e = terms.residual, inv_den = 1.0F / (terms.gradient2() + 1e-30F);
    const Pack taper = max(1.0F - e * e * inv_den * inv_cut, 0);
    Pack w = taper * taper * inv_den;
    if (selection.errors || i + Pack::kWidth > points.count()) w *= selected(points, selection, i);
    used += static_cast<int>(above(w, 0).sum());
    const Pack wu = w * u, wv = w * v, we = w * e, ue = we * u, ve = we * v;
    const Pack left[6] = {wu * u, wu * v, wv * v, wu, wv, w}, right[5] = {x * x, x * y, y * y, x, y};
    for (int k = 0; k < 6; ++k) {
      for (int m = 0; m < 5; ++m) A[k][m] += left[k] * right[m];
      A[k][5] += left[k];
    }
    g[0][0] += ue * x, g[0][1] += ue * y, g[0][2] += ue;
    g[1][0] += ve * x, g[1][1] += ve * y, g[1][2] += ve;
    g[2][0] += we * x, g[2][1] += we * y, g[2][2] += we;
  }
  double sums[6][6];
  for (int k = 0; k < 36; ++k) sums[k / 6][k % 6] = A[k / 6][k % 6].sum();
  for (std::size_t r = 0; r < 9; ++r) {
    for (std::size_t c = 0; c < 9; ++c) normal.A[r][c] = sums[kProduct[r / 3][c / 3]][kProduct[r % 3][c % 3]];
    normal.g[r] = g[r / 3][r % 3].sum();
  }
  return used >= 8;
}

/// Bounds of Tukey's weights per iteration, in units of tau^2.
/// They shrink from the error of a sample of seven to slightly more than an inlier.
constexpr std::array<double, 5> kWideToNarrow{16, 6, 6, 2.5, 2.5};

/// d exp(w) / d w_k at 0.
inline Eigen::Matrix3d generator(std::size_t k) {
  return cross_matrix(Eigen::Vector3d::Unit(static_cast<Eigen::Index>(k)));
}

/// Minimises robust Sampson distances over the seven parameters of F = U diag(cos, sin, 0) V^T (Bartoli and
/// Sturm, PAMI 2004).
inline void refine_fundamental(const TwoViewPoints& points, double tau2, Span<const double> cuts,
                               const Selection& selection, Eigen::Matrix3d& F) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(F, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d U = svd.matrixU(), V = svd.matrixV();
  double angle = portable::atan2(svd.singularValues()(1), svd.singularValues()(0));
  EntryNormal normal;
  for (double cut : cuts) {
    const Eigen::Matrix3d S = diagonal(portable::cos(angle), portable::sin(angle)), Vt = V.transpose();
    F = times(times(U, S), Vt);
    if (!accumulate_epipolar(points, F, cut * tau2, selection, normal)) return;
    EntryDerivatives D;
    for (std::size_t k = 0; k < 3; ++k) {
      const Eigen::Matrix3d turn = generator(k);
      D[k] = to_array(times(times(times(U, turn), S), Vt));
      D[3 + k] = to_array(times(times(times(U, S), turn.transpose()), Vt));
    }
    D[6] = to_array(times(times(U, diagonal(-portable::sin(angle), portable::cos(angle))), Vt));
    std::array<double, 8> delta;
    if (!normal.step(D, 7, delta)) return;
    U = times(U, exp_so3({delta[0], delta[1], delta[2]}));
    V = times(V, exp_so3({delta[3], delta[4], delta[5]}));
    angle += delta[6];
  }
  F = times(times(U, diagonal(portable::cos(angle), portable::sin(angle))), V.transpose());
}

/// A calibrated two-view motion up to scale.
struct Essential {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Vector3d t = Eigen::Vector3d::UnitX();  ///< unit
};

/// K^-1 in normalised coordinates, per image.
struct Calibration {
  Eigen::Matrix3d K1_inv, K2_inv;
  Eigen::Matrix3d fundamental(const Essential& e) const {
    return times(times(K2_inv.transpose(), cross_matrix(e.t)), times(e.R, K1_inv));
  }
  Eigen::Matrix3d rotation(const Eigen::Matrix3d& R) const {
    return times(times(K2_inv.inverse(), R), K1_inv);
  }
};

/// Like refine_fundamental, over the five parameters of E = [t]x R.
inline void refine_essential(const TwoViewPoints& points, const Calibration& K, double cut2, int iterations,
                             const Selection& selection, Essential& e) {
  EntryNormal normal;
  for (int i = 0; i < iterations; ++i) {
    if (!accumulate_epipolar(points, K.fundamental(e), cut2, selection, normal)) return;
    const Eigen::Vector3d b1 = e.t.unitOrthogonal(), b2 = e.t.cross(b1);
    EntryDerivatives D;
    const auto of_entries = [&](const Eigen::Matrix3d& dE) {
      return to_array(times(times(K.K2_inv.transpose(), dE), K.K1_inv));
    };
    const Eigen::Matrix3d tx = cross_matrix(e.t);
    for (std::size_t k = 0; k < 3; ++k) D[k] = of_entries(times(times(tx, generator(k)), e.R));
    D[3] = of_entries(times(cross_matrix(b1), e.R));
    D[4] = of_entries(times(cross_matrix(b2), e.R));
    std::array<double, 8> delta;
    if (!normal.step(D, 5, delta)) return;
    e.R = times(exp_so3({delta[0], delta[1], delta[2]}), e.R);
    e.t += delta[3] * b1;
    e.t += delta[4] * b2;
    e.t.normalize();
  }
}

/// Reweighted transfer residuals d = at - x2, at = H x1, with Tukey's weights on HomographyError.
/// With p = (x, y, 1) and q = H p, d(at) = (p, 0, -at.x p; 0, p, -at.y p) / q.z.
/// Every entry of the normal matrix is one of four weights times one of six products in p p^T.
inline bool accumulate_transfer(const TwoViewPoints& points, const Eigen::Matrix3d& H, double cut2,
                                const Selection& selection, EntryNormal& normal) {
  float h[9];
  for (int i = 0; i < 9; ++i) h[i] = static_cast<float>(H(i / 3, i % 3));
  Pack A[4][6], g[3][3];
  for (auto& row : A) std::fill(row, row + 6, Pack(0));
  for (auto& row : g) std::fill(row, row + 3, Pack(0));
  const float inv_cut = static_cast<float>(1 / (kTransferScale * cut2));
  int used = 0;
  const std::size_t end = std::min(selection.count, points.count());
  for (std::size_t i = 0; i < end; i += Pack::kWidth) {
    const Pack x = points.x(i), y = points.y(i);
    const Pack Z = h[6] * x + h[7] * y + h[8],
               inv = Z / max(Z * Z, 1e-30F);  // 0 on the line that H maps to infinity
    const Pack X = (h[0] * x + h[1] * y + h[2]) * inv, Y = (h[3] * x + h[4] * y + h[5]) * inv;
    const Pack dx = X - points.u(i), dy = Y - points.v(i);
    const Pack taper = max(1.0F - (dx * dx + dy * dy) * inv_cut, 0);
    Pack wi = taper * taper * inv;
    if (selection.errors || i + Pack::kWidth > points.count()) wi *= selected(points, selection, i);
    const Pack w = wi * inv;
    used += static_cast<int>(above(w, 0).sum());
    const Pack left[4] = {w, w * X, w * Y, w * (X * X + Y * Y)}, right[5] = {x * x, x * y, y * y, x, y};
    for (int k = 0; k < 4; ++k) {
      for (int m = 0; m < 5; ++m) A[k][m] += left[k] * right[m];
      A[k][5] += left[k];
    }
    const Pack along[3] = {wi * dx, wi * dy, wi * (dx * X + dy * Y)};
    for (int k = 0; k < 3; ++k) g[k][0] += along[k] * x, g[k][1] += along[k] * y, g[k][2] += along[k];
  }
  double sums[4][6];
  for (int k = 0; k < 24; ++k) sums[k / 6][k % 6] = A[k / 6][k % 6].sum();
  normal.A = {};
  for (std::size_t r = 0; r < 3; ++r) {
    for (std::size_t c = 0; c < 3; ++c) {
      const int product = kProduct[r][c];
      normal.A[r][c] = normal.A[3 + r][3 + c] = sums[0][product];
      normal.A[r][6 + c] = normal.A[6 + c][r] = -sums[1][product];
      normal.A[3 + r][6 + c] = normal.A[6 + c][3 + r] = -sums[2][product];
      normal.A[6 + r][6 + c] = sums[3][product];
    }
    normal.g[r] = g[0][r].sum(), normal.g[3 + r] = g[1][r].sum(), normal.g[6 + r] = -g[2][r].sum();
  }
  return used >= 4;
}

/// Minimises robust transfer distances over eight entries. H(2, 2) remains 1.
inline void refine_homography(const TwoViewPoints& points, double cut2, int iterations,
                              const Selection& selection, Eigen::Matrix3d& H) {
  EntryNormal normal;
  EntryDerivatives D{};
  for (std::size_t k = 0; k < 8; ++k) D[k][k] = 1;
  for (int i = 0; i < iterations; ++i) {
    std::array<double, 8> delta;
    if (!accumulate_transfer(points, H, cut2, selection, normal) || !normal.step(D, 8, delta)) return;
    for (int k = 0; k < 8; ++k) H(k / 3, k % 3) += delta[static_cast<std::size_t>(k)];
  }
}

/// The same over the three parameters of the camera's rotation, H = K R K^-1.
inline void refine_rotation(const TwoViewPoints& points, const Calibration& K, double cut2, int iterations,
                            const Selection& selection, Eigen::Matrix3d& R) {
  EntryNormal normal;
  const Eigen::Matrix3d K2 = K.K2_inv.inverse();
  for (int i = 0; i < iterations; ++i) {
    if (!accumulate_transfer(points, times(times(K2, R), K.K1_inv), cut2, selection, normal)) return;
    EntryDerivatives D;
    for (std::size_t k = 0; k < 3; ++k) D[k] = to_array(times(times(K2, generator(k)), times(R, K.K1_inv)));
    std::array<double, 8> delta;
    if (!normal.step(D, 3, delta)) return;
    R = times(exp_so3({delta[0], delta[1], delta[2]}), R);
  }
}

}  // namespace dynfilter::detail
