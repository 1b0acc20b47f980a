// SPDX-License-Identifier: MIT
// The switch between instruction sets, and loads and stores at every address.
#include <array>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <dynfilter/core/avx2.hpp>
#include <dynfilter/core/cpu.hpp>
#include <dynfilter/core/lanes.hpp>
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

#if defined(DYNFILTER_X86)
DYNFILTER_AVX2 void wide_round_trips(const std::int16_t* shorts, const unsigned char* bytes,
                                     const float* floats, std::int16_t* copied, std::int16_t* widened,
                                     float* sum) {
  detail::avx2::store(copied, detail::avx2::load(shorts));
  detail::avx2::store(widened, detail::avx2::load_bytes(bytes));
  *sum = detail::avx2::sum(detail::avx2::load(floats));
}
#endif

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
    Shifted<float> from(8, offset), to(8, offset);
    detail::Pack::load(from.data()).store(to.data());
    CHECK(std::memcmp(from.data(), to.data(), 8 * sizeof(float)) == 0);
    CHECK(detail::Pack::load(from.data()).sum() == kSum);
#if defined(DYNFILTER_X86)
    if (!uses_avx2()) continue;
    check_round_trip<detail::Lanes<8>::Float, float>(offset);
    check_round_trip<detail::Lanes<8>::Int, std::int32_t>(offset);
    Shifted<std::int16_t> shorts(16, offset), copied(17, offset), widened(17, offset);
    for (std::size_t byte = 0; byte < sizeof(float); ++byte) {
      Shifted<unsigned char> bytes(16, offset + byte);
      float sum = 0;
      wide_round_trips(shorts.data(), bytes.data(), from.data(), copied.data(), widened.data(), &sum);
      CHECK(std::memcmp(shorts.data(), copied.data(), kRegister) == 0);
      for (std::size_t k = 0; k < 16; ++k) CHECK(widened.data()[k] == bytes.data()[k]);
      CHECK(sum == kSum);
    }
#endif
  }
}

}  // namespace cpu_test
