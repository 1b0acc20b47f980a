// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <cstring>
#include <dynfilter/core/cpu.hpp>
#include <dynfilter/core/simd.hpp>
#include <dynfilter/mapping/voxel_key.hpp>
#include <opencv2/core.hpp>

namespace dynfilter::mapping::detail {

/// Points to be added to a grid. A block of 256 fits the first-level cache.
struct PointBlock {
  static constexpr int kSize = 256;
  int n = 0;
  alignas(32) float x[kSize], y[kSize], z[kSize];  ///< entries from n on are ignored
  std::uint32_t colour[kSize];                     ///< b | g << 8 | r << 16
  std::uint8_t label[kSize];
  alignas(32) std::int32_t usable[kSize];  ///< 0 or 1
};

/// How a grid divides space and its hash table.
struct GridScale {
  float per_unit;  ///< quanta per metre
  int sub_bits;    ///< a leaf is 2^sub_bits quanta
  int table_bits;
};

/// Keys, table positions and remainders of a block's points.
struct KeyedBlock {
  static constexpr int kFar = 64, kNear = 12;  ///< prefetch distance of table entries, then of keys
  alignas(32) std::uint64_t key[PointBlock::kSize];
  alignas(32) std::uint32_t place[PointBlock::kSize + kFar];
  alignas(32) std::int32_t rest[3][PointBlock::kSize];  ///< position within the voxel, in quanta
  alignas(32) std::int32_t cell[3][PointBlock::kSize];
  alignas(32) std::int32_t ok[PointBlock::kSize];  ///< 0 or 1
  /// The contribution of a point to its voxel: four 16-bit numbers.
  /// From the lowest bits: x, y and z of rest, and 1.
  alignas(32) std::uint64_t summand[PointBlock::kSize];
};

/// Cell and remainder of every point for one axis.
/// Points that are infinite, NaN or out of the keys' range become not ok.
template <class L>
DYNFILTER_AS_CALLER inline void split_axis(const float* v, int n, const GridScale& scale, std::int32_t* cell,
                                           std::int32_t* rest, std::int32_t* ok) {
  using Float = typename L::Float;
  using Int = typename L::Int;
  const float limit = static_cast<float>(VoxelKey::kOffset) * static_cast<float>(1 << scale.sub_bits);
  const std::int32_t mask = (1 << scale.sub_bits) - 1;
  for (int i = 0; i < n; i += L::kCount) {
    Float units;
    Int good, q;
    dynfilter::detail::load_lane(v + i, units);
    dynfilter::detail::load_lane(ok + i, good);
    units *= scale.per_unit;
    const Int inside = (units < limit) & (units >= -limit);
    dynfilter::detail::truncate_inside<L>(units, inside, q);
    // Floor, because the conversion truncates towards zero.
    q += (__builtin_convertvector(q, Float) > units) & inside;
    dynfilter::detail::store_lane(cell + i, Int(q >> scale.sub_bits));
    dynfilter::detail::store_lane(rest + i, Int(q & mask));
    dynfilter::detail::store_lane(ok + i, Int(good & inside));
  }
}

/// Keys, table positions and summands of a block's points. Compilers vectorise this loop.
DYNFILTER_AS_CALLER inline void make_keys(const std::uint8_t* label, int n, int table_bits,
                                          KeyedBlock& keyed) {
  for (int i = 0; i < n; ++i) {
    const VoxelKey::Halves key =
        VoxelKey::halves(keyed.cell[0][i], keyed.cell[1][i], keyed.cell[2][i], label[i]);
    keyed.key[i] = VoxelKey::whole(key);
    keyed.place[i] = VoxelKey::place(key, table_bits);
    const auto xy = static_cast<std::uint32_t>(keyed.rest[0][i] | keyed.rest[1][i] << 16);
    const auto z_and_one = static_cast<std::uint32_t>(keyed.rest[2][i] | 1 << 16);
    keyed.summand[i] = xy | static_cast<std::uint64_t>(z_and_one) << 32;
  }
}

template <class L>
DYNFILTER_AS_CALLER inline void split_points(const PointBlock& block, const GridScale& scale,
                                             KeyedBlock& keyed) {
  std::memcpy(keyed.ok, block.usable, sizeof keyed.ok);
  split_axis<L>(block.x, block.n, scale, keyed.cell[0], keyed.rest[0], keyed.ok);
  split_axis<L>(block.y, block.n, scale, keyed.cell[1], keyed.rest[1], keyed.ok);
  split_axis<L>(block.z, block.n, scale, keyed.cell[2], keyed.rest[2], keyed.ok);
  make_keys(block.label, block.n, scale.table_bits, keyed);
}

/// Converts points to three arrays.
DYNFILTER_AS_CALLER inline void take_points(const cv::Point3f* points, int n, PointBlock& block) {
  static_assert(sizeof(cv::Point3f) == 3 * sizeof(float));
  const float* from = &points->x;
  float* __restrict x = block.x, * __restrict y = block.y, * __restrict z = block.z;
  for (int k = 0; k < n; ++k) x[k] = from[3 * k], y[k] = from[3 * k + 1], z[k] = from[3 * k + 2];
  block.n = n;
}

}  // namespace dynfilter::mapping::detail
