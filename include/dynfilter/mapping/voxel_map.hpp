// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <dynfilter/mapping/voxel_key.hpp>
#include <utility>
#include <vector>

namespace dynfilter::mapping {

/// A weighted point in the world, as integer multiples of the map's quantum.
/// It can be added to a VoxelMap and removed again exactly.
struct WorldPoint {
  std::array<std::int32_t, 3> units;
  std::uint32_t weight;
  std::uint8_t b, g, r, label;
};

/// The sums of a voxel. All are integers, so adding and subtracting is exact in any order.
struct Voxel {
  std::array<std::int64_t, 3> weighted_units{};  ///< sum of weight x coordinates
  std::uint32_t weight = 0;                      ///< pixels
  std::uint32_t points = 0;                      ///< keyframe points; at 0 the voxel is removed
  std::array<std::uint32_t, 3> colour{};         ///< sums over points: blue, green, red

  bool operator==(const Voxel& o) const {
    return weighted_units == o.weighted_units && weight == o.weight && points == o.points &&
           colour == o.colour;
  }
};

/// How many views see a surface in a voxel, and how many see through it (depth_view.hpp).
/// Stored apart from the sums, because a view votes on all visible voxels and this step is memory-bound.
struct VoxelVotes {
  std::uint16_t seen = 0, through = 0;          ///< votes of stored views
  std::uint16_t old_seen = 0, old_through = 0;  ///< votes of permanent views, at most 65535

  bool operator==(const VoxelVotes& o) const {
    return seen == o.seen && through == o.through && old_seen == o.old_seen && old_through == o.old_through;
  }
};

/// Voxels of the world by key, in an open-addressing table. The leaf is 2^(kLeafBits + level) quanta. Keys
/// nest, so the leaf can double without a change of the sums. The set of voxels and their sums depend only on
/// the content, not on order or history. Only the order of the lists does. Memory: 64 bytes per voxel and 8
/// to 16 bytes of table.
class VoxelMap {
 public:
  static constexpr int kLeafBits = 12;  ///< 4096 quanta per leaf

  /// The leaf is 2^level times the smallest.
  explicit VoxelMap(int level = 0) : level_(level) { resize_table(10); }

  int level() const { return level_; }  ///< how often the leaf was doubled
  std::size_t size() const { return keys_.size(); }
  const std::vector<std::uint64_t>& keys() const { return keys_.keys(); }  ///< one per voxel
  const KeyList& key_list() const { return keys_; }                        ///< the same with boxes of batches
  std::vector<Voxel>& voxels() { return voxels_; }                         ///< sums, one per voxel
  const std::vector<Voxel>& voxels() const { return voxels_; }
  /// One entry per voxel.
  std::vector<VoxelVotes>& votes() { return votes_; }
  const std::vector<VoxelVotes>& votes() const { return votes_; }
  /// Memory that it takes [bytes].
  std::size_t bytes() const {
    return keys_.bytes() + voxels_.capacity() * sizeof(Voxel) + votes_.capacity() * sizeof(VoxelVotes) +
           table_.capacity() * sizeof(table_[0]);
  }

  /// Of the voxel that contains the point.
  std::uint64_t key_of(const WorldPoint& p) const {
    const int shift = kLeafBits + level_;
    return VoxelKey::pack(p.units[0] >> shift, p.units[1] >> shift, p.units[2] >> shift, p.label);
  }

  /// Adds points. New voxels are appended, from the previous size on.
  void add(const WorldPoint* points, std::size_t n);
  /// Removes points that were added with equal numbers. Empty voxels are removed.
  void subtract(const WorldPoint* points, std::size_t n);

  /// Doubles the leaf and adds the sums. Votes of stored views become 0 and must be cast again.
  /// Votes of permanent views become the maximum.
  void coarsen();

  /// Result of find() if the voxel does not exist.
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};
  /// Index of the voxel; kNone: there is none.
  std::uint32_t find(std::uint64_t key) const {
    const std::uint32_t mask = static_cast<std::uint32_t>(table_.size()) - 1;
    for (std::uint32_t place = VoxelKey::place(key, bits_);; place = (place + 1) & mask) {
      if (table_[place] == 0) return kNone;
      if (keys_[table_[place] - 1] == key) return table_[place] - 1;
    }
  }

 private:
  /// Calls f(key, point) and prefetches the table entries of later points.
  template <class F>
  void for_each_ahead(const WorldPoint* points, std::size_t n, const F& f);

  std::uint32_t find_or_make(std::uint64_t key);

  /// Moves the last voxel of the lists to this index.
  /// Later table entries move up (linear probing without tombstones, Knuth vol. 3, sec. 6.4, algorithm R).
  void erase(std::uint32_t i);
  std::uint32_t place_of(std::uint32_t i) const;
  void resize_table(int bits);

  int level_ = 0, bits_ = 0;
  KeyList keys_;
  std::vector<Voxel> voxels_;
  std::vector<VoxelVotes> votes_;
  std::vector<std::uint32_t> table_;  ///< index + 1, 0: free
};

inline void VoxelMap::add(const WorldPoint* points, std::size_t n) {
  for_each_ahead(points, n, [&](std::uint64_t key, const WorldPoint& p) {
    Voxel& v = voxels_[find_or_make(key)];
    for (std::size_t a = 0; a < 3; ++a) v.weighted_units[a] += std::int64_t{p.units[a]} * p.weight;
    v.weight += p.weight;
    ++v.points;
    v.colour[0] += p.b, v.colour[1] += p.g, v.colour[2] += p.r;
  });
}

inline void VoxelMap::subtract(const WorldPoint* points, std::size_t n) {
  for_each_ahead(points, n, [&](std::uint64_t key, const WorldPoint& p) {
    const std::uint32_t i = find(key);
    if (i == kNone) return;
    Voxel& v = voxels_[i];
    for (std::size_t a = 0; a < 3; ++a) v.weighted_units[a] -= std::int64_t{p.units[a]} * p.weight;
    v.weight -= p.weight;
    v.colour[0] -= p.b, v.colour[1] -= p.g, v.colour[2] -= p.r;
    if (--v.points == 0) erase(i);
  });
}

inline void VoxelMap::coarsen() {
  VoxelMap coarse(level_ + 1);
  for (std::size_t i = 0; i < keys_.size(); ++i) {
    const std::uint32_t at = coarse.find_or_make(VoxelKey::coarser(keys_[i], 1));
    Voxel& to = coarse.voxels_[at];
    const Voxel& from = voxels_[i];
    for (std::size_t a = 0; a < 3; ++a) {
      to.weighted_units[a] += from.weighted_units[a];
      to.colour[a] += from.colour[a];
    }
    to.weight += from.weight;
    to.points += from.points;
    VoxelVotes& votes = coarse.votes_[at];
    votes.old_seen = std::max(votes.old_seen, votes_[i].old_seen);
    votes.old_through = std::max(votes.old_through, votes_[i].old_through);
  }
  *this = std::move(coarse);
}

template <class F>
void VoxelMap::for_each_ahead(const WorldPoint* points, std::size_t n, const F& f) {
  constexpr std::size_t kAhead = 16;
  std::uint64_t keys[kAhead];
  for (std::size_t begin = 0; begin < n; begin += kAhead) {
    const std::size_t count = std::min(kAhead, n - begin);
    for (std::size_t k = 0; k < count; ++k) {
      keys[k] = key_of(points[begin + k]);
      __builtin_prefetch(&table_[VoxelKey::place(keys[k], bits_)]);
    }
    for (std::size_t k = 0; k < count; ++k) {
      const std::uint32_t i = table_[VoxelKey::place(keys[k], bits_)];
      if (i == 0) continue;
      __builtin_prefetch(&keys_.keys()[i - 1]);
      __builtin_prefetch(&voxels_[i - 1]);
    }
    for (std::size_t k = 0; k < count; ++k) f(keys[k], points[begin + k]);
  }
}

inline std::uint32_t VoxelMap::find_or_make(std::uint64_t key) {
  const std::uint32_t mask = static_cast<std::uint32_t>(table_.size()) - 1;
  std::uint32_t place = VoxelKey::place(key, bits_);
  for (; table_[place] != 0; place = (place + 1) & mask)
    if (keys_[table_[place] - 1] == key) return table_[place] - 1;
  keys_.push_back(key);
  voxels_.emplace_back();
  votes_.emplace_back();
  const auto made = static_cast<std::uint32_t>(keys_.size());
  table_[place] = made;
  if (keys_.size() * 2 > table_.size()) resize_table(bits_ + 1);
  return made - 1;
}

inline void VoxelMap::erase(std::uint32_t i) {
  const std::uint32_t mask = static_cast<std::uint32_t>(table_.size()) - 1;
  std::uint32_t hole = place_of(i);
  const auto last = static_cast<std::uint32_t>(keys_.size()) - 1;
  if (i != last) {
    table_[place_of(last)] = i + 1;
    keys_.replace(i, keys_[last]);
    voxels_[i] = voxels_[last];
    votes_[i] = votes_[last];
  }
  keys_.pop_back();
  voxels_.pop_back();
  votes_.pop_back();
  table_[hole] = 0;
  for (std::uint32_t next = (hole + 1) & mask; table_[next] != 0; next = (next + 1) & mask) {
    const std::uint32_t home = VoxelKey::place(keys_[table_[next] - 1], bits_);
    if (((next - home) & mask) < ((next - hole) & mask)) continue;
    table_[hole] = table_[next];
    table_[next] = 0;
    hole = next;
  }
}

inline std::uint32_t VoxelMap::place_of(std::uint32_t i) const {
  const std::uint32_t mask = static_cast<std::uint32_t>(table_.size()) - 1;
  std::uint32_t place = VoxelKey::place(keys_[i], bits_);
  while (table_[place] != i + 1) place = (place + 1) & mask;
  return place;
}

inline void VoxelMap::resize_table(int bits) {
  bits_ = bits;
  table_.assign(std::size_t{1} << bits, 0);
  const std::uint32_t mask = static_cast<std::uint32_t>(table_.size()) - 1;
  for (std::uint32_t i = 0; i < keys_.size(); ++i) {
    std::uint32_t place = VoxelKey::place(keys_[i], bits_);
    while (table_[place] != 0) place = (place + 1) & mask;
    table_[place] = i + 1;
  }
}

}  // namespace dynfilter::mapping
