// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstdint>

namespace dynfilter::synth {

/// Random numbers by their place (seed, what for, frame, point) instead of their order: every frame of a
/// scene can be asked for alone and comes out the same on every machine. SplitMix64 (Steele, Lea, Flood
/// 2014).
class PlacedRandom {
 public:
  PlacedRandom(std::uint64_t seed, std::uint64_t purpose, std::int64_t frame, std::int64_t point)
      : state_(mix(seed + mix(purpose + mix(static_cast<std::uint64_t>(frame) +
                                            mix(static_cast<std::uint64_t>(point)))))) {}

  std::uint64_t bits() { return mix(state_ += kGolden); }
  double uniform() { return static_cast<double>(bits() >> 11U) * (1.0 / 9007199254740992.0); }
  double uniform(double low, double high) { return low + (high - low) * uniform(); }
  std::size_t below(std::size_t n) { return static_cast<std::size_t>(bits() % n); }
  /// Standard normal (Box and Muller 1958).
  double gaussian() {
    const double radius = std::sqrt(-2 * std::log(1 - uniform()));
    return radius * std::cos(6.283185307179586 * uniform());
  }

 private:
  static constexpr std::uint64_t kGolden = 0x9E3779B97F4A7C15U;
  static std::uint64_t mix(std::uint64_t z) {
    z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9U;
    z = (z ^ (z >> 27U)) * 0x94D049BB133111EBU;
    return (z ^ (z >> 31U)) + kGolden;
  }

  std::uint64_t state_;
};

}  // namespace dynfilter::synth
