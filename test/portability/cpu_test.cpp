// SPDX-License-Identifier: MIT
// The switch between instruction sets, and loads and stores at every address.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <dynfilter/core/cpu.hpp>
#include <dynfilter/core/simd.hpp>
#include <dynfilter/geometry/sampling.hpp>
#include <limits>
#include <string>
#include <vector>

#include "doctest/doctest.h"

namespace cpu_test {

using namespace dynfilter;

namespace {

constexpr std::size_t kRegister = 32;  ///< bytes of the widest register that our code uses
constexpr float kSum = 8 + 3 * 28;     ///< of the first eight numbers 3 k + 1

/// Memory that starts `offset` bytes behind a multiple of 32.
template <class T>
class Shifted {
 public:
  Shifted(std::size_t n, std::size_t offset) : bytes_(n * sizeof(T) + 2 * kRegister) {
    const auto at = reinterpret_cast<std::uintptr_t>(bytes_.data());
    start_ = (kRegister - at % kRegister) % kRegister + offset;
    for (std::size_t k = 0; k < n; ++k) data()[k] = static_cast<T>(3 * k + 1);
  }
  T* data() { return reinterpret_cast<T*>(bytes_.data() + start_); }

 private:
  std::vector<unsigned char> bytes_;
  std::size_t start_ = 0;
};

template <class Lane, class T>
void check_round_trip(std::size_t offset) {
  constexpr std::size_t n = sizeof(Lane) / sizeof(T);
  Shifted<T> from(n, offset), to(2 * n, offset);
  Lane lane;
  detail::load_lane(from.data(), lane);
  detail::store_lane(to.data(), lane);
  CHECK(std::memcmp(from.data(), to.data(), sizeof lane) == 0);
  CHECK(to.data()[n] == static_cast<T>(3 * n + 1));  // not overwritten
}

template <int kLanes>
void check_pack(std::size_t offset) {
  Shifted<float> from(8, offset), to(9, offset);
  float sum = 0;
  detail::compiled_for<kLanes == 8>([&]() DYNFILTER_AS_CALLER {
    const auto pack = detail::PackOf<kLanes>::load(from.data());
    pack.store(to.data());
    sum = pack.sum();
  });
  CHECK(std::memcmp(from.data(), to.data(), kRegister) == 0);
  CHECK(to.data()[8] == 25.0F);  // not overwritten
  CHECK(sum == kSum);
}

template <int kLanes>
void check_shorts(std::size_t offset, std::size_t byte) {
  constexpr std::size_t n = kLanes;
  Shifted<std::int16_t> shorts(n, offset), copied(n + 1, offset), widened(n, offset), rows(n, offset);
  Shifted<unsigned char> bytes(n, offset + byte), second(8, offset + byte);
  for (std::size_t k = 0; k < 8; ++k) second.data()[k] = static_cast<unsigned char>(200 + k);
  detail::compiled_for<kLanes == 16>([&]() DYNFILTER_AS_CALLER {
    detail::Shorts<kLanes>::load(shorts.data()).store(copied.data());
    detail::load_bytes<kLanes>(bytes.data()).store(widened.data());
    detail::load_rows<kLanes>(bytes.data(), second.data()).store(rows.data());
  });
  CHECK(std::memcmp(shorts.data(), copied.data(), n * sizeof(std::int16_t)) == 0);
  CHECK(copied.data()[n] == static_cast<std::int16_t>(3 * n + 1));  // not overwritten
  for (std::size_t k = 0; k < n; ++k) {
    CHECK(widened.data()[k] == bytes.data()[k]);
    CHECK(rows.data()[k] == (k < 8 ? bytes.data()[k] : second.data()[k - 8]));
  }
}

template <int kLanes>
void check_operations() {
  using P = detail::PackOf<kLanes>;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float a[8] = {1, -2, 0.3F, 4e9F, nan, 7, -0.5F, 1e-3F}, b[8] = {3, -2, 0.7F, 1e-9F, 2, nan, 8, 1e-3F};
  float r[12][8];
  detail::compiled_for<kLanes == 8>([&]() DYNFILTER_AS_CALLER {
    const P x = P::load(a), y = P::load(b);
    (x + y).store(r[0]), (x - y).store(r[1]), (x * y).store(r[2]), (x / y).store(r[3]), (-x).store(r[4]);
    max(x, y).store(r[5]), min(x, y).store(r[6]), above(x, y).store(r[7]), not_above(x, y).store(r[8]);
    sqrt(x * x).store(r[9]), (1 - x * 2).store(r[10]), where_positive(x, y, x).store(r[11]);
  });
  const auto same = [](float found, float expected) {
    return std::isnan(expected) ? std::isnan(found) : found == expected;
  };
  for (int k = 0; k < 8; ++k) {
    CAPTURE(k);
    const float x = a[k], y = b[k];
    const float expected[12] = {x + y,
                                x - y,
                                x * y,
                                x / y,
                                -x,
                                x > y ? x : y,
                                x < y ? x : y,
                                x > y ? 1.0F : 0.0F,
                                x <= y ? 1.0F : 0.0F,
                                std::sqrt(x * x),
                                1 - x * 2,
                                x > 0 ? y : x};
    for (int o = 0; o < 12; ++o) CHECK(same(r[o][k], expected[o]));
  }
}

template <int kLanes>
void check_products() {
  using S = detail::Shorts<kLanes>;
  constexpr int n = kLanes;
  SampleGenerator random(7);
  for (int round = 0; round < 100; ++round) {
    std::int16_t a[n], b[n], high[n], row[n], columns[n], inside[n];
    std::int32_t pairs[n / 2], total = 0, expected = 0, folded[4];
    for (int k = 0; k < n; ++k) {
      a[k] = static_cast<std::int16_t>(static_cast<int>(random.below(65535)) - 32767);
      b[k] = static_cast<std::int16_t>(static_cast<int>(random.below(65535)) - 32767);
    }
    const int first = std::min(a[0], a[1]), last = std::max(a[0], a[1]);
    detail::compiled_for<kLanes == 16>([&]() DYNFILTER_AS_CALLER {
      const S x = S::load(a), y = S::load(b);
      detail::high_product<kLanes>(x, y).store(high);
      detail::next_row<kLanes>(x, y).store(row);
      detail::next_columns<2, kLanes>(x, y).store(columns);
      detail::within<kLanes>(x, first, last).store(inside);
      const auto sums = detail::pair_products<kLanes>(x >> 6, y >> 6);
      sums.store(pairs);
      detail::store_lane(folded, detail::in_four(sums));
      total = detail::sum(sums);
    });
    for (int k = 0; k < n; ++k) {
      CHECK(high[k] == static_cast<int>(std::floor(a[k] * b[k] / 65536.0)));
      CHECK(row[k] == (k + 8 < n ? a[k + 8] : b[k % 8]));
      CHECK(columns[k] == (k % 8 < 6 ? a[k + 2] : b[k - 6]));
      CHECK(inside[k] == (a[k] >= first && a[k] < last ? -1 : 0));
    }
    for (int k = 0; k < n / 2; ++k) {
      CHECK(pairs[k] == (a[2 * k] >> 6) * (b[2 * k] >> 6) + (a[2 * k + 1] >> 6) * (b[2 * k + 1] >> 6));
      expected += pairs[k];
    }
    for (int k = 0; k < 4; ++k) CHECK(folded[k] == pairs[k] + (n == 16 ? pairs[k + 4] : 0));
    CHECK(total == expected);
  }
}

}  // namespace

TEST_CASE("DYNFILTER_SIMD is auto or baseline, and anything else is the safe side") {
  CHECK(simd_choice_of(nullptr) == SimdChoice::Auto);
  CHECK(simd_choice_of("auto") == SimdChoice::Auto);
  CHECK(simd_choice_of("baseline") == SimdChoice::Baseline);
  for (const char* wrong : {"", "Baseline", "baseline ", "avx2", "0"})
    CHECK(simd_choice_of(wrong) == SimdChoice::Unknown);
}

TEST_CASE("AVX2 is used only where the environment allows it") {
  const char* asked = std::getenv("DYNFILTER_SIMD");
  if (asked != nullptr && std::string(asked) != "auto") CHECK_FALSE(uses_avx2());
#if defined(DYNFILTER_X86)
  if (asked == nullptr) CHECK(uses_avx2() == (__builtin_cpu_supports("avx2") != 0));
#else
  CHECK_FALSE(uses_avx2());
#endif
  int lanes = 0;
  detail::call_widest([&](auto width) DYNFILTER_AS_CALLER { lanes = width(); });
  CHECK(lanes == (uses_avx2() ? 8 : 4));
}

TEST_CASE("vectors are loaded and stored at every address") {
  for (std::size_t offset = 0; offset < kRegister; offset += sizeof(float)) {
    CAPTURE(offset);
    check_round_trip<detail::Lanes<4>::Float, float>(offset);
    check_round_trip<detail::Lanes<4>::Int, std::int32_t>(offset);
    check_pack<4>(offset);
    for (std::size_t byte = 0; byte < sizeof(float); ++byte) check_shorts<8>(offset, byte);
    if (!uses_avx2()) continue;
    check_round_trip<detail::Lanes<8>::Float, float>(offset);
    check_round_trip<detail::Lanes<8>::Int, std::int32_t>(offset);
    check_pack<8>(offset);
    for (std::size_t byte = 0; byte < sizeof(float); ++byte) check_shorts<16>(offset, byte);
  }
}

TEST_CASE("operations on packs are those on numbers, at both widths") {
  check_operations<4>();
  if (uses_avx2()) check_operations<8>();
}

TEST_CASE("operations on 16-bit integers are those of their definition, at both widths") {
  check_products<8>();
  if (uses_avx2()) check_products<16>();
}

}  // namespace cpu_test
