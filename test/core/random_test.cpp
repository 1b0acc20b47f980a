// SPDX-License-Identifier: MIT
#include <cstdint>
#include <dynfilter/core/random.hpp>

#include "doctest/doctest.h"

namespace random_test {

using dynfilter::Random;

TEST_CASE(
    "mix_bits is SplitMix64's step: the first two numbers that its authors' program prints for 1234567") {
  CHECK(dynfilter::mix_bits(1234567) == 6457827717110365317ULL);
  CHECK(dynfilter::mix_bits(1234567 + dynfilter::kMixStep) == 3203168211198807973ULL);
}

TEST_CASE("a pixel's row is drawn before its column") {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Random pixels(seed), numbers(seed);
    const cv::Point pixel = pixels.below(cv::Size(640, 480));
    const int first = numbers.below(480), second = numbers.below(640);
    CHECK(pixel == cv::Point(second, first));
    CHECK(pixels.next() == numbers.next());
  }
}

}  // namespace random_test
