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
