// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

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
  /// Of a cell's indices and class.
  static Halves halves(std::int32_t x, std::int32_t y, std::int32_t z, std::uint8_t label) {
    const auto ux = static_cast<std::uint32_t>(x + kOffset), uy = static_cast<std::uint32_t>(y + kOffset),
               uz = static_cast<std::uint32_t>(z + kOffset);
    static_assert(kAxisBits == 18);
    return {ux | uy << 18, uy >> 14 | uz << 4 | static_cast<std::uint32_t>(label) << 22};
  }
  /// The same key as one number.
  static std::uint64_t whole(Halves key) { return key.lower | static_cast<std::uint64_t>(key.upper) << 32; }
  /// Key of a cell's indices and class.
  static std::uint64_t pack(std::int32_t x, std::int32_t y, std::int32_t z, std::uint8_t label = 0) {
    return whole(halves(x, y, z, label));
  }
  /// Index along axis 0, 1 or 2.
  static std::int32_t axis(std::uint64_t key, int a) {
    return static_cast<std::int32_t>(key >> (a * kAxisBits) & kMask) - kOffset;
  }
  /// Class; 0: none.
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

/// Cells from `low` to `high`, both included.
struct CellBox {
  std::array<std::int32_t, 3> low, high;

  /// One cell.
  explicit CellBox(std::uint64_t key)
      : low{VoxelKey::axis(key, 0), VoxelKey::axis(key, 1), VoxelKey::axis(key, 2)}, high(low) {}
  /// Grows to contain this cell.
  void extend(std::uint64_t key) {
    for (int a = 0; a < 3; ++a) {
      const auto i = static_cast<std::size_t>(a);
      low[i] = std::min(low[i], VoxelKey::axis(key, a));
      high[i] = std::max(high[i], VoxelKey::axis(key, a));
    }
  }
};

/// Keys in order of insertion, in batches of 256 with a bounding box each. Voxels that are added together are
/// usually close together. A view therefore skips most batches of a large map (DepthView). A box also covers
/// keys of its batch that were replaced later. After many removals, fewer batches are skipped.
class KeyList {
 public:
  static constexpr std::size_t kBatch = 256;

  std::size_t size() const { return keys_.size(); }
  std::uint64_t operator[](std::size_t i) const { return keys_[i]; }  ///< key i
  const std::vector<std::uint64_t>& keys() const { return keys_; }    ///< all, in order of insertion
  /// Box of the batch that contains key `i`.
  const CellBox& box_of(std::size_t i) const { return boxes_[i / kBatch]; }
  std::size_t bytes() const {
    return keys_.capacity() * sizeof(keys_[0]) + boxes_.capacity() * sizeof(CellBox);
  }

  /// Appends a key.
  void push_back(std::uint64_t key) {
    if (keys_.size() % kBatch == 0)
      boxes_.emplace_back(key);
    else
      boxes_.back().extend(key);
    keys_.push_back(key);
  }
  /// Key i becomes this one.
  void replace(std::size_t i, std::uint64_t key) {
    keys_[i] = key;
    boxes_[i / kBatch].extend(key);
  }
  /// Removes the last key.
  void pop_back() {
    keys_.pop_back();
    if (keys_.size() % kBatch == 0) boxes_.pop_back();
  }

 private:
  std::vector<std::uint64_t> keys_;
  std::vector<CellBox> boxes_;
};

}  // namespace dynfilter::mapping
