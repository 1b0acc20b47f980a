// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

namespace dynfilter::mapping {

/// A grid cell and the class of its content as one number.
/// 18 bits per axis, 8 bits class (0: none). Numbers sort by class, z, y, x.
struct VoxelKey {
  static constexpr int kAxisBits = 18;
  /// Cells range from -kOffset to kOffset - 1.
  static constexpr std::int32_t kOffset = 1 << (kAxisBits - 1);
  static constexpr std::uint64_t kMask = (std::uint64_t{1} << kAxisBits) - 1;

  /// A key as two 32-bit numbers.
  struct Halves {
    std::uint32_t lower, upper;
  };
  static Halves halves(std::int32_t x, std::int32_t y, std::int32_t z, std::uint8_t label) {
    const auto ux = static_cast<std::uint32_t>(x + kOffset), uy = static_cast<std::uint32_t>(y + kOffset),
               uz = static_cast<std::uint32_t>(z + kOffset);
    static_assert(kAxisBits == 18);
    return {ux | uy << 18, uy >> 14 | uz << 4 | static_cast<std::uint32_t>(label) << 22};
  }
  static std::uint64_t whole(Halves key) { return key.lower | static_cast<std::uint64_t>(key.upper) << 32; }
  static std::uint64_t pack(std::int32_t x, std::int32_t y, std::int32_t z, std::uint8_t label = 0) {
    return whole(halves(x, y, z, label));
  }
  static std::int32_t axis(std::uint64_t key, int a) {
    return static_cast<std::int32_t>(key >> (a * kAxisBits) & kMask) - kOffset;
  }
  static std::uint8_t label(std::uint64_t key) { return static_cast<std::uint8_t>(key >> (3 * kAxisBits)); }
  /// The cell that contains this one in a grid with 2^levels times the leaf.
  static std::uint64_t coarser(std::uint64_t key, int levels) {
    return pack(axis(key, 0) >> levels, axis(key, 1) >> levels, axis(key, 2) >> levels, label(key));
  }
  /// Multiplicative (Fibonacci) hashing to a position in a table of 2^bits, 1 <= bits <= 32.
  /// It spreads a lattice of keys more evenly than a random hash.
  static std::uint32_t place(std::uint64_t key, int bits) {
    return static_cast<std::uint32_t>(key * kGolden >> (64 - bits));
  }
  /// The same with multiplications that the vectors of every processor support.
  static std::uint32_t place(Halves key, int bits) {
    constexpr auto lower = static_cast<std::uint32_t>(kGolden),
                   upper = static_cast<std::uint32_t>(kGolden >> 32);
    const auto carried = static_cast<std::uint32_t>(std::uint64_t{key.lower} * lower >> 32);
    return (carried + key.lower * upper + key.upper * lower) >> (32 - bits);
  }

 private:
  static constexpr std::uint64_t kGolden = 0x9E3779B97F4A7C15ULL;
};

}  // namespace dynfilter::mapping
