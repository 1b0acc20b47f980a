// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/mapping/voxel_map.hpp>

#include <algorithm>
#include <dynfilter/core/inline.hpp>
#include <utility>

namespace dynfilter::mapping {

DYNFILTER_INLINE VoxelMap::VoxelMap(int level) : level_(level) {
  resize_table(10);
}

DYNFILTER_INLINE void VoxelMap::add(const WorldPoint* points, std::size_t n) {
  for_each_ahead(points, n, [&](std::uint64_t key, const WorldPoint& p) {
    Voxel& v = voxels_[find_or_make(key)];
    for (std::size_t a = 0; a < 3; ++a) v.weighted_units[a] += std::int64_t{p.units[a]} * p.weight;
    v.weight += p.weight;
    ++v.points;
    v.colour[0] += p.b, v.colour[1] += p.g, v.colour[2] += p.r;
  });
}

DYNFILTER_INLINE void VoxelMap::subtract(const WorldPoint* points, std::size_t n) {
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

DYNFILTER_INLINE void VoxelMap::coarsen() {
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
