// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/cpu.hpp>
#include <dynfilter/core/simd.hpp>
#include <dynfilter/core/span.hpp>
#include <dynfilter/geometry/depth_noise.hpp>
#include <dynfilter/geometry/sampling.hpp>
#include <dynfilter/geometry/small_matrix.hpp>
#include <opencv2/core.hpp>
#include <vector>

namespace dynfilter {

namespace detail {

struct RigidTransform {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Vector3d t = Eigen::Vector3d::Zero();
};

struct RigidNoise {
  double pixel_sigma_px;
  DepthNoise depth;
};

/// Correspondences as structure of arrays, in spread order, so that a prefix is a fair sample.
/// Padded to whole packs with points of zero weight. The score is linear in q, with 1/c.z instead of 1/q.z:
/// residual = W (q.x - a.x q.z, q.y - a.y q.z, q.z - c.z).
struct RigidPoints {
  static constexpr int kPack = Pack::kWidth;
  enum Row { kPx, kPy, kPz, kAx, kAy, kCz, kWx, kWy, kWz, kRows };

  std::size_t count = 0, stride = 0;
  bool wide = true;  ///< use AVX2 where available, with identical results
  std::vector<float> data;
  std::vector<int> indices;

  const float* row(int r) const { return data.data() + static_cast<std::size_t>(r) * stride; }

  void pack(const Camera& camera, const RigidNoise& noise, Span<const cv::Point3f> reference,
            Span<const cv::Point3f> current, Span<const int> seeds) {
    indices.clear();
    const int n = static_cast<int>(std::min(reference.size(), current.size()));
    for (int seed : seeds) {
      const auto i = static_cast<std::size_t>(seed);
      if (seed >= 0 && seed < n && usable(reference[i]) && usable(current[i])) indices.push_back(seed);
    }
    count = indices.size();
    stride = (count + kPack - 1) / kPack * kPack;
    data.resize(stride * kRows);
    std::size_t k = 0;
    visit_spread(count, [&](std::size_t i) {
      const auto index = static_cast<std::size_t>(indices[i]);
      const cv::Point3f &p = reference[index], &c = current[index];
      at(kPx, k) = p.x, at(kPy, k) = p.y, at(kPz, k) = p.z;
      at(kAx, k) = c.x, at(kAy, k) = c.y, at(kCz, k) = c.z;
      ++k;
    });
    for (k = 0; k < stride; k += kPack) derive(k, camera, noise);
    for (k = count; k < stride; ++k) {
      for (int r = 0; r < kRows; ++r) at(r, k) = 0;
    }
  }

  static bool usable(const cv::Point3f& p) {
    return valid_depth(p.z) && std::isfinite(p.x) && std::isfinite(p.y);
  }

  float& at(int r, std::size_t k) { return data[static_cast<std::size_t>(r) * stride + k]; }

  /// Computes the bearing that the residual subtracts, and its weights.
  void derive(std::size_t k, const Camera& camera, const RigidNoise& noise) {
    const Pack inv_z = 1.0F / pack_of(kCz, k);
    const Pack sp = sigma_m(noise.depth, pack_of(kPz, k)), sc = sigma_m(noise.depth, pack_of(kCz, k));
    put(kAx, k, pack_of(kAx, k) * inv_z);
    put(kAy, k, pack_of(kAy, k) * inv_z);
    put(kWx, k, static_cast<float>(camera.fx_px / noise.pixel_sigma_px) * inv_z);
    put(kWy, k, static_cast<float>(camera.fy_px / noise.pixel_sigma_px) * inv_z);
    put(kWz, k, 1.0F / sqrt(sp * sp + sc * sc));
  }
  static Pack sigma_m(const DepthNoise& noise, const Pack& depth_m) {
    const Pack d = depth_m - static_cast<float>(noise.offset_m);
    return static_cast<float>(noise.base_m) + static_cast<float>(noise.quadratic_per_m) * (d * d);
  }

  template <class P = Pack>
  DYNFILTER_AS_CALLER P pack_of(int r, std::size_t i) const {
    return P::load(row(r) + i);
  }
  void put(int r, std::size_t i, const Pack& pack) { pack.store(&at(r, i)); }

  template <class P = Pack>
  DYNFILTER_AS_CALLER P chi2(const float (&m)[12], std::size_t i) const {
    const auto get = [&](int r) DYNFILTER_AS_CALLER { return pack_of<P>(r, i); };
    const P px = get(kPx), py = get(kPy), pz = get(kPz);
    const P qz = m[8] * px + m[9] * py + m[10] * pz + m[11];
    const P qx = m[0] * px + m[1] * py + m[2] * pz + m[3];
    const P qy = m[4] * px + m[5] * py + m[6] * pz + m[7];
    const P rx = (qx - get(kAx) * qz) * get(kWx);
    const P ry = (qy - get(kAy) * qz) * get(kWy);
    const P rz = (qz - get(kCz)) * get(kWz);
    return rx * rx + ry * ry + rz * rz;
  }

  static void to_float(const RigidTransform& T, float (&m)[12]) {
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) m[4 * r + c] = static_cast<float>(T.R(r, c));
      m[4 * r + 3] = static_cast<float>(T.t(r));
    }
  }

  /// Sum of max(0, 1 - chi2/limit) (MSAC, Torr and Zisserman 2000). Returns 0 as soon as the sum cannot reach
  /// `floor`, either for certain or by three standard deviations of a prefix estimate.
  double score(const RigidTransform& T, float limit, double floor) const {
    float m[12];
    to_float(T, m);
    const float inv = 1 / limit;
    const double share = floor / static_cast<double>(count);
    double total = 0;
    constexpr std::size_t kBlock = 64;
    for (std::size_t i = 0; i < stride;) {
      const std::size_t end = std::min(stride, i + kBlock);
      total += block_score(m, inv, i, end);
      i = end;
      const double seen = static_cast<double>(i);
      if (total < share * seen - 1.5 * std::sqrt(seen)) return 0;
    }
    total -= padding_score(m, inv);
    return total > floor ? total : 0;
  }

  float block_score(const float (&m)[12], float inv_limit, std::size_t begin, std::size_t end) const {
    return call_widest(
        [&](auto lanes) DYNFILTER_AS_CALLER {
          using P = PackOf<lanes()>;
          P sum = 0;
          for (std::size_t i = begin; i < end; i += kPack) sum += max(1 - chi2<P>(m, i) * inv_limit, 0);
          return sum.sum();
        },
        wide);
  }

  double padding_score(const float (&m)[12], float inv) const {
    if (stride == count) return 0;
    const Pack last = max(1 - chi2(m, stride - kPack) * inv, 0);
    double sum = 0;
    for (std::size_t k = count; k < stride; ++k) sum += last[static_cast<int>(k % kPack)];
    return sum;
  }

  int inliers(const RigidTransform& T, float limit) const {
    float m[12];
    to_float(T, m);
    Pack n = 0;
    for (std::size_t i = 0; i < stride; i += kPack) n += above(limit, chi2(m, i));
    // Residuals of the padding are 0, or NaN if T overflows.
    const auto padding = static_cast<int>(stride - count);
    return std::max(0, static_cast<int>(n.sum()) - (limit > 0 ? padding : 0));
  }

  Eigen::Vector3d reference(std::size_t k) const { return {row(kPx)[k], row(kPy)[k], row(kPz)[k]}; }
  Eigen::Vector3d current(std::size_t k) const {
    const double z = row(kCz)[k];
    return {row(kAx)[k] * z, row(kAy)[k] * z, z};
  }

  /// Pose from three points by aligning their orthonormal frames (TRIAD, Black 1964) at their centroids.
  /// False for nearly collinear points, and if the triangles' sides differ by more than noise.
  bool solve_triple(const std::uint32_t (&pick)[3], RigidTransform& T) const {
    Eigen::Vector3d p[3], c[3];
    double slack2 = 0;
    for (int i = 0; i < 3; ++i) {
      p[i] = reference(pick[i]), c[i] = current(pick[i]);
      const double w = std::min({row(kWx)[pick[i]], row(kWy)[pick[i]], row(kWz)[pick[i]]});
      slack2 = std::max(slack2, 18 / (w * w));  // (3 sigma sqrt 2)^2
    }
    const double slack = std::sqrt(slack2);
    for (int i = 0; i < 3; ++i) {
      const int j = (i + 1) % 3;
      const Eigen::Vector3d then = p[i] - p[j], now = c[i] - c[j];
      if (std::abs(then.norm() - now.norm()) > slack) return false;
    }
    Eigen::Matrix3d P, C;
    if (!frame_of(p, P) || !frame_of(c, C)) return false;
    T.R = times(C, P.transpose());
    const Eigen::Vector3d then = p[0] + p[1] + p[2];
    T.t = c[0] + c[1] + c[2];
    T.t -= T.R * then;
    T.t /= 3;
    return true;
  }

  static bool frame_of(const Eigen::Vector3d (&p)[3], Eigen::Matrix3d& frame) {
    Eigen::Vector3d x = p[1] - p[0];
    const Eigen::Vector3d other = p[2] - p[0];
    Eigen::Vector3d z = x.cross(other);
    const double length2 = x.squaredNorm(), area2 = z.squaredNorm();
    if (!(area2 > 1e-6 * length2 * other.squaredNorm()) || !(length2 > 1e-12)) return false;
    x /= std::sqrt(length2);
    z /= std::sqrt(area2);
    frame = columns(x, z.cross(x), z);
    return true;
  }
};

}  // namespace detail
}  // namespace dynfilter
