// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/mapping/voxel_grid.hpp>

#include <algorithm>
#include <dynfilter/core/error.hpp>
#include <dynfilter/core/inline.hpp>
#include <dynfilter/core/lanes.hpp>
#include <opencv2/core.hpp>

namespace dynfilter::mapping {

namespace detail {

DYNFILTER_INLINE void FourSums::add(std::uint64_t summand) {
  using FourShort = std::uint16_t __attribute__((vector_size(8)));
  FourShort four;
  std::memcpy(&four, &summand, sizeof four);
  v += __builtin_convertvector(four, Four);
}

}  // namespace detail

DYNFILTER_INLINE VoxelGrid::VoxelGrid(double leaf_m) {
  set_leaf(leaf_m);
}

DYNFILTER_INLINE void VoxelGrid::set_leaf(double leaf_m) {
  if (!(leaf_m >= 1e-4 && leaf_m <= 1e3)) throw ConfigError("leaf_m", "expected 0.0001 to 1000");
  leaf_m_ = leaf_m;
}

DYNFILTER_INLINE void VoxelGrid::run(Span<const cv::Point3f> points_m, Span<const cv::Vec3b> colours,
                                     std::vector<VoxelPoint>& out) {
  begin(points_m.size());
  const bool coloured = colours.size() == points_m.size();
  for (std::size_t i = 0; i < points_m.size(); i += detail::PointBlock::kSize) {
    const auto n = static_cast<int>(std::min<std::size_t>(detail::PointBlock::kSize, points_m.size() - i));
    dynfilter::detail::call_widest(
        [&](auto) DYNFILTER_AS_CALLER { detail::take_points(points_m.data() + i, n, block_); });
    std::fill(block_.usable, block_.usable + n, 1);
    std::memset(block_.label, 0, sizeof block_.label);
    if (coloured) {
      for (int k = 0; k < block_.n; ++k) block_.colour[k] = packed(colours[i + static_cast<std::size_t>(k)]);
    }
    add_block(coloured);
  }
  finish(coloured, out);
}

DYNFILTER_INLINE void VoxelGrid::run(const DepthSource& source, std::vector<VoxelPoint>& out) {
  const cv::Mat& depth = source.depth;
  const bool known = depth.type() == CV_16UC1 || depth.type() == CV_32FC1;
  const bool readable = known && source.rays != nullptr && depth.size() == source.rays->size();
  const cv::Rect all(0, 0, readable ? depth.cols : 0, readable ? depth.rows : 0);
  const cv::Rect area = source.area.empty() ? all : (source.area & all);
  begin(static_cast<std::size_t>(area.area()));
  const bool coloured = fits(source.bgr, depth, CV_8UC3) || fits(source.bgr, depth, CV_8UC1);
  // Tiles of 32 x 8 pixels: neighbours share voxels while these are in the cache.
  for (int y = area.y; y < area.y + area.height; y += kTileRows)
    for (int x = area.x; x < area.x + area.width; x += kTileColumns) {
      const cv::Rect tile = cv::Rect(x, y, kTileColumns, kTileRows) & area;
      dynfilter::detail::call_widest([&](auto) DYNFILTER_AS_CALLER { read_tile(source, tile, coloured); });
      add_block(coloured);
    }
  finish(coloured, out);
}

inline DYNFILTER_AS_CALLER std::uint32_t VoxelGrid::packed(const cv::Vec3b& c) {
  return static_cast<std::uint32_t>(c[0]) | static_cast<std::uint32_t>(c[1]) << 8 |
         static_cast<std::uint32_t>(c[2]) << 16;
}

inline void VoxelGrid::begin(std::size_t points) {
  sub_bits_ = 12;
  while (sub_bits_ > 2 && points >> (32 - sub_bits_) != 0) --sub_bits_;
  per_unit_ = static_cast<float>(static_cast<double>(1 << sub_bits_) / leaf_m_);
  voxels_ = 0;
  outside_ = 0;
  if (table_.empty()) resize_table(16);
  reserve_block();
}

inline DYNFILTER_AS_CALLER void VoxelGrid::read_tile(const DepthSource& source, const cv::Rect& tile,
                                                     bool coloured) {
  const auto unit = static_cast<float>(source.unit_m);
  block_.n = 0;
  for (int y = tile.y; y < tile.y + tile.height; ++y) {
    const int n = tile.width, at = block_.n;
    float *px = block_.x + at, *py = block_.y + at, *pz = block_.z + at;
    detail::read_points(source.depth, unit, source.range, *source.rays, y, tile.x, n, px, py, pz);
    for (int k = 0; k < n; ++k) block_.usable[at + k] = pz[k] > 0 ? 1 : 0;
    if (fits(source.usable, source.depth, CV_8UC1)) {
      const std::uint8_t* usable = source.usable.ptr<std::uint8_t>(y) + tile.x;
      for (int k = 0; k < n; ++k) block_.usable[at + k] &= usable[k] != 0 ? 1 : 0;
    }
    if (fits(source.labels, source.depth, CV_8UC1))
      std::memcpy(block_.label + at, source.labels.ptr<std::uint8_t>(y) + tile.x,
                  static_cast<std::size_t>(n));
    else
      std::memset(block_.label + at, 0, static_cast<std::size_t>(n));
    if (coloured) read_colours(source.bgr, y, tile.x, n, block_.colour + at);
    block_.n += n;
  }
}

inline DYNFILTER_AS_CALLER void VoxelGrid::read_colours(const cv::Mat& bgr, int y, int x0, int n,
                                                        std::uint32_t* out) {
  if (bgr.type() == CV_8UC1) {
    const std::uint8_t* grey = bgr.ptr<std::uint8_t>(y) + x0;
    for (int k = 0; k < n; ++k) out[k] = grey[k] * 0x010101U;
    return;
  }
  const cv::Vec3b* colours = bgr.ptr<cv::Vec3b>(y) + x0;
  for (int k = 0; k < n; ++k) out[k] = packed(colours[k]);
}

inline void VoxelGrid::add_block(bool coloured) {
  const int n = block_.n;
  detail::KeyedBlock& keyed = keyed_;
  const detail::GridScale scale{per_unit_, sub_bits_, bits_};
  dynfilter::detail::call_widest([&](auto lanes) DYNFILTER_AS_CALLER {
    detail::split_points<dynfilter::detail::Lanes<lanes()>>(block_, scale, keyed);
  });
  for (int i = 0; i < std::min(n, kFar); ++i) __builtin_prefetch(&table_[keyed.place[i]], 1);
  int outside = 0;
  for (int i = 0; i < n; ++i) outside += block_.usable[i] & ~keyed.ok[i];
  outside_ += static_cast<std::size_t>(outside);
  // Padding for the prefetch beyond the block's end.
  std::fill(keyed.place + n, keyed.place + n + kFar, 0U);
  coloured ? insert<true>() : insert<false>();
  if (std::size_t{voxels_} * 5 > table_.size() * 2) resize_table(bits_ + 1);
  reserve_block();
}

template <bool kColoured>
void VoxelGrid::insert() {
  const std::uint32_t mask = static_cast<std::uint32_t>(table_.size()) - 1;
  std::uint32_t* const table = table_.data();
  std::uint64_t* const keys = keys_.data();
  detail::FourSums* const sums = sums_.data();
  detail::FourSums* const colours = colours_.data();
  std::uint32_t voxels = voxels_;
  for (int i = 0; i < block_.n; ++i) {
    __builtin_prefetch(&table[keyed_.place[i + kFar]], 1);
    __builtin_prefetch(&keys[table[keyed_.place[i + kNear]]], 1);
    if (keyed_.ok[i] == 0) continue;
    const std::uint64_t key = keyed_.key[i];
    std::uint32_t place = keyed_.place[i], j = table[place];
    for (;;) {
      // 1 for a new voxel, written so that no compiler makes it a branch.
      // The next voxel is prepared before it is known whether it is needed.
      const std::uint32_t made = (j - 1) >> 31;
      keys[voxels + 1] = key;
      sums[voxels + 1] = {};
      if constexpr (kColoured) colours[voxels + 1] = {};
      voxels += made;
      j |= voxels & (0 - made);
      table[place] = j;
      if (__builtin_expect(keys[j] == key ? 1 : 0, 1) != 0) break;
      place = (place + 1) & mask;
      j = table[place];
    }
    sums[j].add(keyed_.summand[i]);
    if constexpr (kColoured) {
      const std::uint32_t c = block_.colour[i];
      colours[j].v += Four{c & 255U, c >> 8 & 255U, c >> 16, 0};
    }
  }
  voxels_ = voxels;
}

inline void VoxelGrid::reserve_block() {
  const std::size_t needed = std::size_t{voxels_} + detail::PointBlock::kSize + 1;
  if (needed <= sums_.size()) return;
  const std::size_t size = needed + needed / 2;
  keys_.resize(size);
  sums_.resize(size);
  colours_.resize(size);
}

inline void VoxelGrid::resize_table(int bits) {
  bits_ = bits;
  table_.assign(std::size_t{1} << bits, 0);
  const std::uint32_t mask = static_cast<std::uint32_t>(table_.size()) - 1;
  for (std::uint32_t j = 1; j <= voxels_; ++j) {
    std::uint32_t place = VoxelKey::place(keys_[j], bits_);
    while (table_[place] != 0) place = (place + 1) & mask;
    table_[place] = j;
  }
}

inline void VoxelGrid::finish(bool coloured, std::vector<VoxelPoint>& out) {
  out.resize(voxels_);
  dynfilter::detail::call_widest([&](auto) DYNFILTER_AS_CALLER { write_voxels(coloured, out.data()); });
  std::memset(table_.data(), 0, table_.size() * sizeof(table_[0]));
  const bool far_too_large = bits_ > 16 && std::size_t{voxels_} * 32 < table_.size();
  voxels_ = 0;
  if (far_too_large) resize_table(bits_ - 1);
}

inline DYNFILTER_AS_CALLER void VoxelGrid::write_voxels(bool coloured, VoxelPoint* out) const {
  const detail::CentroidScale scale{leaf_m_ / (1 << sub_bits_), static_cast<double>(1 << sub_bits_)};
  for (std::uint32_t j = 1; j <= voxels_; ++j) detail::write_centroid(sums_[j], keys_[j], scale, out[j - 1]);
  if (!coloured) return;
  for (std::uint32_t j = 1; j <= voxels_; ++j) detail::write_colour(colours_[j], out[j - 1]);
}

}  // namespace dynfilter::mapping
