// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cmath>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/geometry/small_matrix.hpp>
#include <opencv2/core.hpp>

namespace dynfilter {

/// 3x3 matrix on pixel coordinates, row-major.
using Matrix9 = std::array<double, 9>;

namespace detail {

inline Matrix9 to_array(const Eigen::Matrix3d& m) {
  return {m(0, 0), m(0, 1), m(0, 2), m(1, 0), m(1, 1), m(1, 2), m(2, 0), m(2, 1), m(2, 2)};
}

/// (x, y, 1), and H (x, y, 1) in pixels.
inline Eigen::Vector3d lifted(const Eigen::Vector2d& p) {
  return {p.x(), p.y(), 1};
}
inline Eigen::Vector2d mapped(const Eigen::Matrix3d& H, const Eigen::Vector2d& p) {
  const Eigen::Vector3d q = H * lifted(p);
  return {q.x() / q.z(), q.y() / q.z()};
}

/// What all epipolar distances of a match (x, y), (u, v) are made of. T is a number or a pack of them.
/// F is row-major.
template <class T>
struct EpipolarTerms {
  T X, Y;      ///< normal of the line F p1 in the current image
  T A, B;      ///< normal of the line F' p2 in the reference image
  T residual;  ///< p2' F p1

  template <class Entry>
  EpipolarTerms(const Entry* F, const T& x, const T& y, const T& u, const T& v)
      : X(F[0] * x + F[1] * y + F[2]),
        Y(F[3] * x + F[4] * y + F[5]),
        A(F[0] * u + F[3] * v + F[6]),
        B(F[1] * u + F[4] * v + F[7]),
        residual(X * u + Y * v + (F[6] * x + F[7] * y + F[8])) {}

  /// The distance from the line is residual / sqrt(line2()), Sampson's residual / sqrt(gradient2()).
  T line2() const { return X * X + Y * Y; }
  T gradient2() const { return line2() + A * A + B * B; }
};

inline EpipolarTerms<double> epipolar_terms(const Matrix9& F, cv::Point2f reference, cv::Point2f current) {
  return {F.data(), reference.x, reference.y, current.x, current.y};
}

}  // namespace detail

/// Offset [px] of the current point from the epipolar line of the reference point. Its sign is the side of
/// the line, which is the same for neighbours away from the epipole.
/// Infinite if the line is undefined, with the reference point at the epipole.
inline double epipolar_offset_px(const Matrix9& F, cv::Point2f reference, cv::Point2f current) {
  const auto terms = detail::epipolar_terms(F, reference, current);
  const double norm = std::sqrt(terms.line2());
  return norm > 0 ? terms.residual / norm : HUGE_VAL;
}

/// Distance [px] of the current point from the epipolar line of the reference point,
///   D = |p2' F p1| / sqrt(X^2 + Y^2),  (X, Y, Z) = F p1     (RTS-SLAM, eq. 4).
/// Infinite if the line is undefined, with the reference point at the epipole.
inline double epipolar_distance_px(const Matrix9& F, cv::Point2f reference, cv::Point2f current) {
  return std::abs(epipolar_offset_px(F, reference, current));
}

/// `H p` in pixels. Not finite for points on the line that H maps to infinity.
inline cv::Point2d transfer(const Matrix9& H, cv::Point2f p) {
  const double w = H[6] * p.x + H[7] * p.y + H[8];
  return {(H[0] * p.x + H[1] * p.y + H[2]) / w, (H[3] * p.x + H[4] * p.y + H[5]) / w};
}

namespace detail {

inline Eigen::Matrix3d camera_matrix(const Camera& camera) {
  return rows({camera.fx_px, 0, camera.cx_px, 0, camera.fy_px, camera.cy_px, 0, 0, 1});
}

}  // namespace detail
}  // namespace dynfilter
