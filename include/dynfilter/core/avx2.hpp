// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/cpu.hpp>

#if defined(DYNFILTER_X86)
#include <immintrin.h>

#include <cstdint>

/// Loads and stores of whole AVX2 registers. No other file has any of its own (test/layering).
/// Every address is allowed, because no compiler can lose an alignment that is never stated. On processors
/// with AVX2 it costs nothing where data is aligned.
namespace dynfilter::detail::avx2 {

DYNFILTER_AVX2 inline __m256 load(const float* from) {
  return _mm256_loadu_ps(from);
}
DYNFILTER_AVX2 inline __m256i load(const std::int16_t* from) {
  return _mm256_loadu_si256(reinterpret_cast<const __m256i*>(from));
}
DYNFILTER_AVX2 inline void store(std::int16_t* to, const __m256i& v) {
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(to), v);
}
/// Sixteen bytes, each as 16 bits.
DYNFILTER_AVX2 inline __m256i load_bytes(const unsigned char* from) {
  return _mm256_cvtepu8_epi16(_mm_loadu_si128(reinterpret_cast<const __m128i*>(from)));
}

/// In the order of Pack::sum().
DYNFILTER_AVX2 inline float sum(const __m256& v) {
  const __m128 both = _mm256_castps256_ps128(v) + _mm256_extractf128_ps(v, 1);
  return (both[0] + both[2]) + (both[1] + both[3]);
}

}  // namespace dynfilter::detail::avx2
#endif
