// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <dynfilter/mapping/voxel_key.hpp>
#include <vector>

namespace dynfilter::mapping {

/// Cells from `low` to `high`, both included.
struct CellBox {
  std::array<std::int32_t, 3> low, high;

  explicit CellBox(std::uint64_t key)
      : low{VoxelKey::axis(key, 0), VoxelKey::axis(key, 1), VoxelKey::axis(key, 2)}, high(low) {}
  void extend(std::uint64_t key) {
    for (int a = 0; a < 3; ++a) {
      const auto i = static_cast<std::size_t>(a);
      low[i] = std::min(low[i], VoxelKey::axis(key, a));
      high[i] = std::max(high[i], VoxelKey::axis(key, a));
    }
  }
};

/// Keys in order of insertion, in batches of 256 with a bounding box each.
/// Voxels that are added together are usually close together.
/// A view therefore skips most batches of a large map (DepthView).
/// A box also covers keys of its batch that were replaced later.
/// After many removals, fewer batches are skipped.
class KeyList {
 public:
  static constexpr std::size_t kBatch = 256;

  std::size_t size() const { return keys_.size(); }
  std::uint64_t operator[](std::size_t i) const { return keys_[i]; }
  const std::vector<std::uint64_t>& keys() const { return keys_; }
  /// Box of the batch that contains key `i`.
  const CellBox& box_of(std::size_t i) const { return boxes_[i / kBatch]; }
  std::size_t bytes() const {
    return keys_.capacity() * sizeof(keys_[0]) + boxes_.capacity() * sizeof(CellBox);
  }

  void push_back(std::uint64_t key) {
    if (keys_.size() % kBatch == 0)
      boxes_.emplace_back(key);
    else
      boxes_.back().extend(key);
    keys_.push_back(key);
  }
  void replace(std::size_t i, std::uint64_t key) {
    keys_[i] = key;
    boxes_[i / kBatch].extend(key);
  }
  void pop_back() {
    keys_.pop_back();
    if (keys_.size() % kBatch == 0) boxes_.pop_back();
  }

 private:
  std::vector<std::uint64_t> keys_;
  std::vector<CellBox> boxes_;
};

}  // namespace dynfilter::mapping
