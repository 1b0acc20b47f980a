// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <cstring>
#if defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace dynfilter::detail {

// Vector types of GCC and Clang: + - * & >> < work per lane on any processor.
// OpenCV 4.11 removed these operators from its own vector types.
// The two products below are SSE2 instructions; other processors use equivalent loops.
using Int16x8 = std::int16_t __attribute__((vector_size(16)));
using Int32x4 = std::int32_t __attribute__((vector_size(16)));
using Float32x4 = float __attribute__((vector_size(16)));

inline Int16x8 all(int value) {
  return Int16x8{} + static_cast<std::int16_t>(value);
}
inline Int16x8 load(const std::int16_t* from) {
  Int16x8 v;
  std::memcpy(&v, from, sizeof v);
  return v;
}
inline void store(std::int16_t* to, const Int16x8& v) {
  std::memcpy(to, &v, sizeof v);
}

#if defined(__SSE2__)
inline constexpr bool kFastShortVectors = true;

inline Int16x8 load_bytes(const unsigned char* from) {
  const __m128i bytes = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(from));
  return reinterpret_cast<Int16x8>(_mm_unpacklo_epi8(bytes, _mm_setzero_si128()));
}
/// a * b / 65536, rounded down.
inline Int16x8 high_product(const Int16x8& a, const Int16x8& b) {
  return reinterpret_cast<Int16x8>(
      _mm_mulhi_epi16(reinterpret_cast<__m128i>(a), reinterpret_cast<__m128i>(b)));
}
/// Lane k: a[2k] * b[2k] + a[2k + 1] * b[2k + 1].
inline Int32x4 pair_products(const Int16x8& a, const Int16x8& b) {
  return reinterpret_cast<Int32x4>(
      _mm_madd_epi16(reinterpret_cast<__m128i>(a), reinterpret_cast<__m128i>(b)));
}
#else
inline constexpr bool kFastShortVectors = false;

inline Int16x8 load_bytes(const unsigned char* from) {
  Int16x8 v;
  for (int k = 0; k < 8; ++k) v[k] = from[k];
  return v;
}
inline Int16x8 high_product(const Int16x8& a, const Int16x8& b) {
  Int16x8 v;
  for (int k = 0; k < 8; ++k) v[k] = static_cast<std::int16_t>((a[k] * b[k]) >> 16);
  return v;
}
inline Int32x4 pair_products(const Int16x8& a, const Int16x8& b) {
  Int32x4 v;
  for (int k = 0; k < 4; ++k) v[k] = a[2 * k] * b[2 * k] + a[2 * k + 1] * b[2 * k + 1];
  return v;
}
#endif

inline Float32x4 to_float(const Int32x4& v) {
  return __builtin_convertvector(v, Float32x4);
}
inline float sum(const Float32x4& v) {
  return (v[0] + v[1]) + (v[2] + v[3]);
}

}  // namespace dynfilter::detail
