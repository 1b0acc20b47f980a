// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/avx2.hpp>

#if defined(DYNFILTER_X86)
#include <cstddef>

namespace dynfilter::detail {

/// RigidPoints::block_score() with the eight lanes in one register. Results are identical.
/// `rows` are in the order of RigidPoints::Row, with `stride` floats each.
DYNFILTER_AVX2 inline float rigid_block_score_avx2(const float* rows, std::size_t stride,
                                                   const float (&m)[12], float inv_limit, std::size_t begin,
                                                   std::size_t end) {
  using Eight = __m256;
  const auto row = [rows, stride](int r, std::size_t i)
                       DYNFILTER_AVX2 { return avx2::load(rows + static_cast<std::size_t>(r) * stride + i); };
  const Eight none = _mm256_setzero_ps(), one = _mm256_set1_ps(1);
  Eight sum = none;
  for (std::size_t i = begin; i < end; i += 8) {
    const Eight px = row(0, i), py = row(1, i), pz = row(2, i);
    const Eight qz = m[8] * px + m[9] * py + m[10] * pz + m[11];
    const Eight qx = m[0] * px + m[1] * py + m[2] * pz + m[3];
    const Eight qy = m[4] * px + m[5] * py + m[6] * pz + m[7];
    const Eight rx = (qx - row(3, i) * qz - row(5, i)) * row(8, i);
    const Eight ry = (qy - row(4, i) * qz - row(6, i)) * row(9, i);
    const Eight rz = (qz - row(7, i)) * row(10, i);
    const Eight fit = one - (rx * rx + ry * ry + rz * rz) * inv_limit;
    sum += _mm256_max_ps(fit, none);  // none for NaN
  }
  return avx2::sum(sum);
}

}  // namespace dynfilter::detail
#endif

#if defined(DYNFILTER_X86)
#include <cstddef>
#include <cstring>
#include <dynfilter/geometry/rigid_motion.hpp>

namespace dynfilter::detail {

/// Input of accumulate_rigid().
/// `rows` are in the order of RigidPoints::Row, with `stride` floats each.
/// `m` is the motion, row-major.
struct RigidSumsInput {
  const float* rows;
  std::size_t stride, end;
  bool image_depth;
  RobustLoss loss;
  float c2;
  float m[12];
};

/// RigidSums over all points with the eight lanes in one register. Results are identical.
class RigidSumsAvx2 {
 public:
  static constexpr int kCount = 28;

  DYNFILTER_AVX2 explicit RigidSumsAvx2(const RigidSumsInput& in) {
    std::memset(sum_, 0, sizeof sum_);
    for (std::size_t i = 0; i < in.end; i += 8) add_points(in, i);
  }

  DYNFILTER_AVX2 float operator[](int k) const { return avx2::sum(sum_[k]); }

 private:
  using Eight = __m256;

  DYNFILTER_AVX2 static Eight row(const RigidSumsInput& in, int r, std::size_t i) {
    return avx2::load(in.rows + static_cast<std::size_t>(r) * in.stride + i);
  }
  DYNFILTER_AVX2 static Eight all(float value) { return _mm256_set1_ps(value); }
  // NaN: returns b.
  DYNFILTER_AVX2 static Eight larger(Eight a, Eight b) { return _mm256_max_ps(a, b); }

  DYNFILTER_AVX2 static Eight weight(const RigidSumsInput& in, Eight s) {
    switch (in.loss) {
      case RobustLoss::None:
        return all(1);
      case RobustLoss::Huber:
        return _mm256_min_ps(_mm256_sqrt_ps(all(in.c2) / larger(s, all(1e-30F))), all(1));
      case RobustLoss::Cauchy:
        return all(1) / (all(1) + s * all(1 / in.c2));
      case RobustLoss::Tukey: {
        const Eight inside = larger(all(1) - s * all(1 / in.c2), all(0));
        return inside * inside;
      }
    }
    return all(1);
  }

  DYNFILTER_AVX2 void add_points(const RigidSumsInput& in, std::size_t i) {
    const float(&m)[12] = in.m;
    const Eight px = row(in, 0, i), py = row(in, 1, i), pz = row(in, 2, i);
    const Eight cz = row(in, 7, i), wz = row(in, 10, i), one = all(1);
    Eight wx = row(in, 8, i), wy = row(in, 9, i), u = all(0), v = all(0), rx, ry;
    const Eight x = all(m[0]) * px + all(m[1]) * py + all(m[2]) * pz + all(m[3]);
    const Eight y = all(m[4]) * px + all(m[5]) * py + all(m[6]) * pz + all(m[7]);
    const Eight z = all(m[8]) * px + all(m[9]) * py + all(m[10]) * pz + all(m[11]);
    Eight valid = _mm256_and_ps(_mm256_cmp_ps(wz, all(0), _CMP_GT_OQ), one);
    if (in.image_depth) {
      valid *= _mm256_and_ps(_mm256_cmp_ps(z, all(1e-3F), _CMP_GT_OQ), one);
      const Eight inv_z = one / larger(z, all(1e-3F));
      u = x * inv_z, v = y * inv_z;
      wx *= cz, wy *= cz;
      rx = wx * (u - row(in, 3, i)), ry = wy * (v - row(in, 4, i));
      wx *= inv_z, wy *= inv_z;
    } else {
      rx = wx * (x - row(in, 5, i)), ry = wy * (y - row(in, 6, i));
    }
    const Eight rz = wz * (z - cz);
    const Eight w = valid * weight(in, rx * rx + ry * ry + rz * rz);
    add({x, y, z}, {wx, -wx * u, wy, -wy * v, wz}, {rx, ry, rz}, w);
  }

  struct Three {
    Eight x, y, z;
  };
  struct Rows {
    Eight a0, a1, a2, a3, a4;
  };

  DYNFILTER_AVX2 void add(const Three& q, const Rows& a, const Three& r, Eight w) {
    const Eight x = q.x, y = q.y, z = q.z, wa = w * a.a0, wb = w * a.a2;
    const Eight m00 = wa * a.a0, m02 = wa * a.a1, m11 = wb * a.a2, m12 = wb * a.a3;
    const Eight m22 = w * (a.a1 * a.a1 + a.a3 * a.a3 + a.a4 * a.a4);
    sum_[0] += m00, sum_[1] += m02, sum_[2] += m11, sum_[3] += m12, sum_[4] += m22;
    const Eight n0 = m02 * y, n1 = m00 * z - m02 * x, n2 = -m00 * y;
    const Eight n3 = m12 * y - m11 * z, n4 = -m12 * x, n5 = m11 * x;
    const Eight n6 = m22 * y - m12 * z, n7 = m02 * z - m22 * x, n8 = m12 * x - m02 * y;
    sum_[5] += n0, sum_[6] += n1, sum_[7] += n2, sum_[8] += n3, sum_[9] += n4;
    sum_[10] += n5, sum_[11] += n6, sum_[12] += n7, sum_[13] += n8;
    sum_[14] += y * n6 - z * n3, sum_[15] += y * n7 - z * n4, sum_[16] += y * n8 - z * n5;
    sum_[17] += z * n1 - x * n7, sum_[18] += z * n2 - x * n8, sum_[19] += x * n5 - y * n2;
    const Eight fx = wa * r.x, fy = wb * r.y, fz = w * (a.a1 * r.x + a.a3 * r.y + a.a4 * r.z);
    sum_[20] += fx, sum_[21] += fy, sum_[22] += fz;
    sum_[23] += y * fz - z * fy, sum_[24] += z * fx - x * fz, sum_[25] += x * fy - y * fx;
    sum_[26] += w * (r.x * r.x + r.y * r.y + r.z * r.z);
    sum_[27] += w;
  }

  Eight sum_[kCount];
};

}  // namespace dynfilter::detail
#endif
