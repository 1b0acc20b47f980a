// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <dynfilter/core/cpu.hpp>
#if defined(__SSE2__)
#include <emmintrin.h>
#endif

/// Vectors of GCC and Clang: + - * & >> < work lane by lane on any processor. Kernels are templates on the
/// number of lanes, marked DYNFILTER_AS_CALLER: narrow vectors work everywhere, wide ones (256 bits) only in
/// code compiled for AVX2. Results are the same. No other file has loads, stores or instructions of its own
/// (test/layering). Every address is allowed. On processors with AVX2 this costs nothing where data happens
/// to be aligned. No compiler can lose an alignment that is never stated. AVX2 is used by built-in functions:
/// <immintrin.h> takes GCC 12 0.7 s in each file that includes a filter. Wide vectors are passed by reference
/// or in a struct, because by value they change the calling convention.
#if defined(__clang__)
#define DYNFILTER_SHUFFLE(V, a, b, ...) __builtin_shufflevector(a, b, __VA_ARGS__)
#define DYNFILTER_HAS_ELEMENTWISE_SQRT __has_builtin(__builtin_elementwise_sqrt)
#else
#define DYNFILTER_SHUFFLE(V, a, b, ...) __builtin_shuffle(a, b, V{__VA_ARGS__})
#define DYNFILTER_HAS_ELEMENTWISE_SQRT 0
#endif

/// Of PackOf: loops over its one or two parts. Clang's checks of their indices take half of a compilation.
#if defined(__clang__)
#define DYNFILTER_BY_PARTS __attribute__((no_sanitize("undefined"))) DYNFILTER_AS_CALLER
#else
#define DYNFILTER_BY_PARTS DYNFILTER_AS_CALLER
#endif

namespace dynfilter::detail {

template <class T, int kLanes>
struct VectorOf {
  using Type __attribute__((vector_size(sizeof(T) * kLanes))) = T;
};
template <class T, int kLanes>
using Vector = typename VectorOf<T, kLanes>::Type;

/// Floats and integers of one width, for conversions that may trap, which compilers do not vectorise.
template <int kLanes>
struct Lanes {
  using Float = Vector<float, kLanes>;
  using Int = Vector<std::int32_t, kLanes>;
  static constexpr int kCount = kLanes;
};

template <class V>
DYNFILTER_AS_CALLER inline void load_lane(const void* from, V& v) {
  std::memcpy(&v, from, sizeof v);
}
template <class V>
DYNFILTER_AS_CALLER inline void store_lane(void* to, const V& v) {
  std::memcpy(to, &v, sizeof v);
}

using Float4 = Vector<float, 4>;
using Int4 = Vector<std::int32_t, 4>;

inline Float4 load_four(const float* from) {
  Float4 v;
  load_lane(from, v);
  return v;
}
inline float sum(const Float4& v) {
  return (v[0] + v[2]) + (v[1] + v[3]);
}

/// Truncates towards zero where `inside` has all bits set, else returns 0.
template <class L>
DYNFILTER_AS_CALLER inline void truncate_inside(const typename L::Float& value, const typename L::Int& inside,
                                                typename L::Int& whole) {
  typename L::Float kept;
  load_lane(&value, whole);
  whole &= inside;
  load_lane(&whole, kept);
  whole = __builtin_convertvector(kept, typename L::Int);
}

// Functions for which the two widths differ. In a function for any processor, GCC 12 builds a wide vector of
// equal lanes one by one, so there is one for AVX2.
inline void fill(float value, Float4& v) {
  v = Float4{value, value, value, value};
}
inline void square_root(Float4& v) {
#if defined(__SSE2__)
  v = _mm_sqrt_ps(v);
#else
  for (int k = 0; k < 4; ++k) v[k] = std::sqrt(v[k]);
#endif
}
/// A bit of each lane: whether it is negative.
inline unsigned sign_bits(const Int4& v) {
#if defined(__SSE2__)
  return static_cast<unsigned>(_mm_movemask_ps(reinterpret_cast<__m128>(v)));
#else
  return (v[0] < 0 ? 1U : 0U) | (v[1] < 0 ? 2U : 0U) | (v[2] < 0 ? 4U : 0U) | (v[3] < 0 ? 8U : 0U);
#endif
}
#if defined(DYNFILTER_X86)
DYNFILTER_AVX2 inline unsigned sign_bits(const Vector<std::int32_t, 8>& v) {
  return static_cast<unsigned>(__builtin_ia32_movmskps256(reinterpret_cast<Vector<float, 8>>(v)));
}
DYNFILTER_AVX2 inline void fill(float value, Vector<float, 8>& v) {
  v = Vector<float, 8>{value, value, value, value, value, value, value, value};
}
DYNFILTER_AVX2 inline void square_root(Vector<float, 8>& v) {
#if DYNFILTER_HAS_ELEMENTWISE_SQRT
  v = __builtin_elementwise_sqrt(v);
#else
  v = __builtin_ia32_sqrtps256(v);
#endif
}
#endif

/// Eight floats with lane-by-lane operations: two vectors on any processor (kLanes 4), or one of AVX2 (8). As
/// fast as Eigen::Array within 4 % (test/benchmark/small_solve_benchmark.cpp), which takes four times as long
/// to compile, because each expression has its own type. The order of sums is the same with every compiler.
template <int kLanes>
struct PackOf {
  using Part = Vector<float, kLanes>;
  static constexpr int kWidth = 8, kParts = kWidth / kLanes;

  Part part[static_cast<std::size_t>(kParts)];

  PackOf() = default;
  DYNFILTER_BY_PARTS PackOf(float value) {  // NOLINT: converts a number to eight copies
    for (Part& p : part) fill(value, p);
  }
  DYNFILTER_BY_PARTS static PackOf load(const float* from) {
    PackOf r;
    for (int k = 0; k < kParts; ++k) load_lane(from + k * kLanes, r.part[k]);
    return r;
  }
  DYNFILTER_BY_PARTS void store(float* to) const {
    for (int k = 0; k < kParts; ++k) store_lane(to + k * kLanes, part[k]);
  }

  DYNFILTER_BY_PARTS float operator[](int k) const { return part[k / kLanes][k % kLanes]; }
  DYNFILTER_BY_PARTS void set(int k, float value) { part[k / kLanes][k % kLanes] = value; }
  DYNFILTER_BY_PARTS float sum() const {
    Float4 low, high;
    load_lane(part, low);
    load_lane(reinterpret_cast<const char*>(part) + sizeof low, high);
    return detail::sum(low + high);
  }

  DYNFILTER_BY_PARTS PackOf& operator+=(const PackOf& o) {
    for (int k = 0; k < kParts; ++k) part[k] += o.part[k];
    return *this;
  }
  DYNFILTER_BY_PARTS PackOf& operator*=(const PackOf& o) {
    for (int k = 0; k < kParts; ++k) part[k] *= o.part[k];
    return *this;
  }
  DYNFILTER_BY_PARTS friend PackOf operator-(const PackOf& a) {
    PackOf r;
    for (int k = 0; k < kParts; ++k) r.part[k] = -a.part[k];
    return r;
  }
  DYNFILTER_BY_PARTS friend PackOf operator+(const PackOf& a, const PackOf& b) { return PackOf(a) += b; }
  DYNFILTER_BY_PARTS friend PackOf operator*(const PackOf& a, const PackOf& b) { return PackOf(a) *= b; }
  DYNFILTER_BY_PARTS friend PackOf operator-(const PackOf& a, const PackOf& b) {
    PackOf r;
    for (int k = 0; k < kParts; ++k) r.part[k] = a.part[k] - b.part[k];
    return r;
  }
  DYNFILTER_BY_PARTS friend PackOf operator/(const PackOf& a, const PackOf& b) {
    PackOf r;
    for (int k = 0; k < kParts; ++k) r.part[k] = a.part[k] / b.part[k];
    return r;
  }
  /// Returns the second operand where the first is NaN.
  DYNFILTER_BY_PARTS friend PackOf max(const PackOf& a, const PackOf& b) {
    PackOf r;
    for (int k = 0; k < kParts; ++k) r.part[k] = a.part[k] > b.part[k] ? a.part[k] : b.part[k];
    return r;
  }
  DYNFILTER_BY_PARTS friend PackOf min(const PackOf& a, const PackOf& b) {
    PackOf r;
    for (int k = 0; k < kParts; ++k) r.part[k] = a.part[k] < b.part[k] ? a.part[k] : b.part[k];
    return r;
  }
  /// 1 where a > b, else 0.
  DYNFILTER_BY_PARTS friend PackOf above(const PackOf& a, const PackOf& b) {
    PackOf r = 1;
    for (int k = 0; k < kParts; ++k) r.part[k] = a.part[k] > b.part[k] ? r.part[k] : Part{};
    return r;
  }
  /// 1 where a <= b, else 0; 0 for NaN.
  DYNFILTER_BY_PARTS friend PackOf not_above(const PackOf& a, const PackOf& b) {
    PackOf r = 1;
    for (int k = 0; k < kParts; ++k) r.part[k] = a.part[k] <= b.part[k] ? r.part[k] : Part{};
    return r;
  }
  /// `a` where x > 0, else `b`.
  DYNFILTER_BY_PARTS friend PackOf where_positive(const PackOf& x, const PackOf& a, const PackOf& b) {
    PackOf r;
    for (int k = 0; k < kParts; ++k) r.part[k] = x.part[k] > Part{} ? a.part[k] : b.part[k];
    return r;
  }
  DYNFILTER_BY_PARTS friend PackOf sqrt(const PackOf& a) {
    PackOf r = a;
    for (Part& p : r.part) square_root(p);
    return r;
  }
};
using Pack = PackOf<4>;

using Short8 = Vector<std::int16_t, 8>;
using Short16 = Vector<std::int16_t, 16>;

// Of 16-bit integers, which lie in rows of eight lanes. The templates are for other processors.
template <class V>
inline void high_product(const V& a, const V& b, V& r) {
  for (std::size_t k = 0; k < sizeof r / 2; ++k) r[k] = static_cast<std::int16_t>((a[k] * b[k]) >> 16);
}
template <class V, class Sums>
inline void pair_products(const V& a, const V& b, Sums& r) {
  for (std::size_t k = 0; k < sizeof r / 4; ++k) r[k] = a[2 * k] * b[2 * k] + a[2 * k + 1] * b[2 * k + 1];
}
inline void load_rows(const unsigned char* row, const unsigned char* /*second*/, Short8& v) {
#if defined(__SSE2__)
  const __m128i bytes = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(row));
  v = reinterpret_cast<Short8>(_mm_unpacklo_epi8(bytes, _mm_setzero_si128()));
#else
  for (int k = 0; k < 8; ++k) v[k] = row[k];
#endif
}
inline void next_row(const Short8& /*a*/, const Short8& b, Short8& r) {
  r = b;
}
template <int kBy>
inline void next_columns(const Short8& a, const Short8& b, Short8& r) {
#if defined(__SSE2__)
  r = reinterpret_cast<Short8>(_mm_or_si128(_mm_srli_si128(reinterpret_cast<__m128i>(a), 2 * kBy),
                                            _mm_slli_si128(reinterpret_cast<__m128i>(b), 16 - 2 * kBy)));
#else
  r = DYNFILTER_SHUFFLE(Short8, a, b, kBy, kBy + 1, kBy + 2, kBy + 3, kBy + 4, kBy + 5, kBy + 6, kBy + 7);
#endif
}
inline void fill(std::int16_t value, Short8& v) {
  v = Short8{} + value;
}
#if defined(__SSE2__)
inline void high_product(const Short8& a, const Short8& b, Short8& r) {
  r = reinterpret_cast<Short8>(_mm_mulhi_epi16(reinterpret_cast<__m128i>(a), reinterpret_cast<__m128i>(b)));
}
inline void pair_products(const Short8& a, const Short8& b, Int4& r) {
  r = reinterpret_cast<Int4>(_mm_madd_epi16(reinterpret_cast<__m128i>(a), reinterpret_cast<__m128i>(b)));
}
#endif

template <class Bytes>
DYNFILTER_AVX2 inline void widen(const Bytes& bytes, Short16& v) {
#if defined(DYNFILTER_X86) && !defined(__clang__)  // GCC 12 converts the halves one by one
  v = __builtin_ia32_pmovzxbw256(reinterpret_cast<Vector<char, 16>>(bytes));
#else
  v = __builtin_convertvector(reinterpret_cast<Vector<unsigned char, 16>>(bytes), Short16);
#endif
}
DYNFILTER_AVX2 inline void load_rows(const unsigned char* first, const unsigned char* second, Short16& v) {
  std::uint64_t rows[2];
  std::memcpy(&rows[0], first, sizeof rows[0]);
  std::memcpy(&rows[1], second, sizeof rows[1]);
  widen(Vector<std::uint64_t, 2>{rows[0], rows[1]}, v);
}
inline void load_bytes(const unsigned char* from, Short8& v) {
  load_rows(from, from, v);
}
DYNFILTER_AVX2 inline void load_bytes(const unsigned char* from, Short16& v) {
  Vector<unsigned char, 16> bytes;
  std::memcpy(&bytes, from, sizeof bytes);
  widen(bytes, v);
}
DYNFILTER_AVX2 inline void next_row(const Short16& a, const Short16& b, Short16& r) {
  r = DYNFILTER_SHUFFLE(Short16, a, b, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20, 21, 22, 23);
}
template <int kBy>
DYNFILTER_AVX2 inline void next_columns(const Short16& a, const Short16& b, Short16& r) {
  static_assert(kBy == 1 || kBy == 2);
  if constexpr (kBy == 1)
    r = DYNFILTER_SHUFFLE(Short16, a, b, 1, 2, 3, 4, 5, 6, 7, 16, 9, 10, 11, 12, 13, 14, 15, 24);
  else
    r = DYNFILTER_SHUFFLE(Short16, a, b, 2, 3, 4, 5, 6, 7, 16, 17, 10, 11, 12, 13, 14, 15, 24, 25);
}
DYNFILTER_AVX2 inline void fill(std::int16_t value, Short16& v) {
  v = Short16{} + value;
}
#if defined(DYNFILTER_X86)
DYNFILTER_AVX2 inline void high_product(const Short16& a, const Short16& b, Short16& r) {
  r = __builtin_ia32_pmulhw256(a, b);
}
DYNFILTER_AVX2 inline void pair_products(const Short16& a, const Short16& b, Vector<std::int32_t, 8>& r) {
  r = __builtin_ia32_pmaddwd256(a, b);
}
#endif

template <class T, int kLanes>
struct Integers {
  Vector<T, kLanes> v;

  DYNFILTER_AS_CALLER static Integers load(const T* from) {
    Integers r;
    load_lane(from, r.v);
    return r;
  }
  DYNFILTER_AS_CALLER void store(T* to) const { store_lane(to, v); }

  DYNFILTER_AS_CALLER Integers& operator+=(const Integers& o) {
    v += o.v;
    return *this;
  }
  DYNFILTER_AS_CALLER friend Integers operator+(const Integers& a, const Integers& b) { return {a.v + b.v}; }
  DYNFILTER_AS_CALLER friend Integers operator-(const Integers& a, const Integers& b) { return {a.v - b.v}; }
  DYNFILTER_AS_CALLER friend Integers operator*(const Integers& a, const Integers& b) { return {a.v * b.v}; }
  DYNFILTER_AS_CALLER friend Integers operator&(const Integers& a, const Integers& b) { return {a.v & b.v}; }
  DYNFILTER_AS_CALLER friend Integers operator<<(const Integers& a, int bits) { return {a.v << bits}; }
  DYNFILTER_AS_CALLER friend Integers operator>>(const Integers& a, int bits) { return {a.v >> bits}; }
};

/// 16-bit integers, eight on any processor or sixteen with AVX2, and 32-bit sums of pairs of them.
template <int kLanes>
using Shorts = Integers<std::int16_t, kLanes>;
template <int kLanes>
using PairSums = Integers<std::int32_t, kLanes / 2>;

template <int kLanes>
DYNFILTER_AS_CALLER inline Shorts<kLanes> all(int value) {
  Shorts<kLanes> r;
  fill(static_cast<std::int16_t>(value), r.v);
  return r;
}
/// Eight bytes of one row, or of each of two with AVX2.
template <int kLanes>
DYNFILTER_AS_CALLER inline Shorts<kLanes> load_rows(const unsigned char* first, const unsigned char* second) {
  Shorts<kLanes> r;
  load_rows(first, second, r.v);
  return r;
}
/// kLanes bytes from one address.
template <int kLanes>
DYNFILTER_AS_CALLER inline Shorts<kLanes> load_bytes(const unsigned char* from) {
  Shorts<kLanes> r;
  load_bytes(from, r.v);
  return r;
}
/// One row further: row 0 of b, or row 1 of a and row 0 of b.
template <int kLanes>
DYNFILTER_AS_CALLER inline Shorts<kLanes> next_row(const Shorts<kLanes>& a, const Shorts<kLanes>& b) {
  Shorts<kLanes> r;
  next_row(a.v, b.v, r.v);
  return r;
}
/// `kBy` columns further in every row: b follows a.
template <int kBy, int kLanes>
DYNFILTER_AS_CALLER inline Shorts<kLanes> next_columns(const Shorts<kLanes>& a, const Shorts<kLanes>& b) {
  Shorts<kLanes> r;
  next_columns<kBy>(a.v, b.v, r.v);
  return r;
}
/// a * b / 65536, rounded down.
template <int kLanes>
DYNFILTER_AS_CALLER inline Shorts<kLanes> high_product(const Shorts<kLanes>& a, const Shorts<kLanes>& b) {
  Shorts<kLanes> r;
  high_product(a.v, b.v, r.v);
  return r;
}
/// Lane k: a[2k] * b[2k] + a[2k + 1] * b[2k + 1].
template <int kLanes>
DYNFILTER_AS_CALLER inline PairSums<kLanes> pair_products(const Shorts<kLanes>& a, const Shorts<kLanes>& b) {
  PairSums<kLanes> r;
  pair_products(a.v, b.v, r.v);
  return r;
}
/// All bits set where the lane is in [first, last).
template <int kLanes>
DYNFILTER_AS_CALLER inline Shorts<kLanes> within(const Shorts<kLanes>& v, int first, int last) {
  return {(v.v >= all<kLanes>(first).v) & (v.v < all<kLanes>(last).v)};
}
/// Sums of the lanes k and k + 4.
DYNFILTER_AS_CALLER inline Int4 in_four(const Integers<std::int32_t, 4>& v) {
  return v.v;
}
DYNFILTER_AS_CALLER inline Int4 in_four(const Integers<std::int32_t, 8>& v) {
  Int4 low, high;
  load_lane(&v, low);
  load_lane(reinterpret_cast<const char*>(&v) + sizeof low, high);
  return low + high;
}
template <int kLanes>
DYNFILTER_AS_CALLER inline std::int32_t sum(const Integers<std::int32_t, kLanes>& v) {
  const Int4 four = in_four(v), two = four + DYNFILTER_SHUFFLE(Int4, four, four, 2, 3, 0, 1);
  return (two + DYNFILTER_SHUFFLE(Int4, two, two, 1, 0, 3, 2))[0];
}

}  // namespace dynfilter::detail

#undef DYNFILTER_BY_PARTS
#undef DYNFILTER_SHUFFLE
#undef DYNFILTER_HAS_ELEMENTWISE_SQRT
