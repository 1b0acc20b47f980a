// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <dynfilter/core/cpu.hpp>
#include <dynfilter/core/error.hpp>
#include <dynfilter/core/simd.hpp>
#include <dynfilter/core/span.hpp>
#include <dynfilter/mapping/depth_points.hpp>
#include <dynfilter/mapping/point_block.hpp>
#include <dynfilter/mapping/voxel_key.hpp>
#include <opencv2/core.hpp>
#include <vector>

namespace dynfilter::mapping {

/// Centroid of a voxel, in the frame of the input points.
struct VoxelPoint {
  float x, y, z;
  std::uint8_t b, g, r;  ///< mean colour, rounded
  std::uint8_t label;    ///< class, 0: no class
  std::uint32_t count;   ///< number of points in the voxel

  bool operator==(const VoxelPoint& o) const {
    return x == o.x && y == o.y && z == o.z && b == o.b && g == o.g && r == o.r && label == o.label &&
           count == o.count;
  }
};

/// What a voxel grid reads from a depth image.
struct DepthSource {
  cv::Mat depth;  ///< CV_16UC1 or CV_32FC1
  double unit_m = 1;
  DepthRange range;
  const PixelRays* rays = nullptr;  ///< with the size of the depth image
  /// CV_8UC3 or CV_8UC1 with the size of the depth image; empty: grey.
  cv::Mat bgr;
  cv::Mat usable;  ///< CV_8UC1: pixels that are not 0 are used; empty: all
  cv::Mat labels;  ///< CV_8UC1: classes, which are kept apart; empty: 0
  cv::Rect area;   ///< empty: the whole image
};

namespace detail {

/// In a struct, because a template argument would lose the attribute.
struct FourSums {
  using Four = dynfilter::detail::Vector<std::uint32_t, 4>;
  Four v{};

  /// Adds four 16-bit numbers.
  void add(std::uint64_t summand) {
    using FourShort = dynfilter::detail::Vector<std::uint16_t, 4>;
    FourShort four;
    std::memcpy(&four, &summand, sizeof four);
    v += __builtin_convertvector(four, Four);
  }
};

/// A grid's quantum, and the conversion from sums of quanta to metres.
struct CentroidScale {
  double unit_m, units_per_leaf;
};

/// Half a quantum compensates the floor of each coordinate.
DYNFILTER_AS_CALLER inline void write_centroid(const FourSums& sums, std::uint64_t key,
                                               const CentroidScale& scale, VoxelPoint& out) {
  using FourInts = dynfilter::detail::Int4;
  using FourFloats = dynfilter::detail::Float4;
  using FourDoubles = dynfilter::detail::Vector<double, 4>;
  const FourInts cell{VoxelKey::axis(key, 0), VoxelKey::axis(key, 1), VoxelKey::axis(key, 2), 0};
  // Conversions are of signed numbers.
  const FourInts sum = reinterpret_cast<FourInts>(sums.v) ^ INT32_MIN;
  const double share = 1.0 / static_cast<double>(sums.v[3]);
  const FourDoubles units = __builtin_convertvector(cell, FourDoubles) * scale.units_per_leaf +
                            (__builtin_convertvector(sum, FourDoubles) + 2147483648.0) * share + 0.5;
  auto words = reinterpret_cast<FourInts>(__builtin_convertvector(units * scale.unit_m, FourFloats));
  words[3] = static_cast<std::int32_t>(0x808080U | std::uint32_t{VoxelKey::label(key)} << 24);
  static_assert(offsetof(VoxelPoint, b) == 12 && offsetof(VoxelPoint, label) == 15);
  std::memcpy(&out, &words, sizeof words);
  out.count = sums.v[3];
}
DYNFILTER_AS_CALLER inline void write_colour(const FourSums& sum, VoxelPoint& out) {
  const std::uint32_t half = out.count / 2;
  out.b = static_cast<std::uint8_t>((sum.v[0] + half) / out.count);
  out.g = static_cast<std::uint8_t>((sum.v[1] + half) / out.count);
  out.r = static_cast<std::uint8_t>((sum.v[2] + half) / out.count);
}

}  // namespace detail

/// The voxel grid of RTS-SLAM (eq. 15-19): voxel v = floor(p / leaf). The result has one point per voxel, the
/// centroid of its points. Coordinates are summed as integer multiples of leaf / 4096. The sums are exact and
/// do not depend on the points' order. The error of a centroid is at most this quantum. Above 2^20 points,
/// the quantum doubles with each doubling. Voxels are in the order in which points first reach them. Classes
/// are kept apart.
///
/// Cost: linear. A voxel grid is memory-bound, because each point accesses a table larger than the caches.
/// Keys of 256 points are therefore computed together and their table entries are prefetched.
/// The table holds only 4-byte indices.
/// A new voxel is created without a branch, which would be unpredictable at small leaves. Buffers are reused.
class VoxelGrid {
 public:
  /// Throws ConfigError unless 1e-4 m <= leaf_m <= 1e3 m.
  explicit VoxelGrid(double leaf_m = 0.02) { set_leaf(leaf_m); }

  /// Width of a cell [m]; throws as above.
  void set_leaf(double leaf_m) {
    if (!(leaf_m >= 1e-4 && leaf_m <= 1e3)) throw ConfigError("leaf_m", "expected 0.0001 to 1000");
    leaf_m_ = leaf_m;
  }
  double leaf_m() const { return leaf_m_; }  ///< width of a cell [m]

  /// In any one frame of reference. Skips points that are not finite or beyond 131072 leaves from the origin.
  /// `colours` may be empty.
  void run(Span<const cv::Point3f> points_m, Span<const cv::Vec3b> colours, std::vector<VoxelPoint>& out) {
    begin(points_m.size());
    const bool coloured = colours.size() == points_m.size();
    for (std::size_t i = 0; i < points_m.size(); i += detail::PointBlock::kSize) {
      const auto n = static_cast<int>(std::min<std::size_t>(detail::PointBlock::kSize, points_m.size() - i));
      dynfilter::detail::call_widest(
          [&](auto) DYNFILTER_AS_CALLER { detail::take_points(points_m.data() + i, n, block_); });
      std::fill(block_.usable, block_.usable + n, 1);
      std::memset(block_.label, 0, sizeof block_.label);
      if (coloured) {
        for (int k = 0; k < block_.n; ++k)
          block_.colour[k] = packed(colours[i + static_cast<std::size_t>(k)]);
      }
      add_block(coloured);
    }
    finish(coloured, out);
  }

  /// Reads a depth image directly, without intermediate points. Images of other types or sizes than the depth
  /// image are ignored. Without rays of that size the result is empty.
  void run(const DepthSource& source, std::vector<VoxelPoint>& out) {
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

  /// Points of the last run that were too far from the origin or not finite.
  std::size_t outside() const { return outside_; }

 private:
  static constexpr int kTileColumns = 32, kTileRows = 8;
  static constexpr int kFar = detail::KeyedBlock::kFar, kNear = detail::KeyedBlock::kNear;
  static_assert(kTileColumns * kTileRows == detail::PointBlock::kSize);
  using Four = detail::FourSums::Four;

  static std::uint32_t packed(const cv::Vec3b& c) {
    return static_cast<std::uint32_t>(c[0]) | static_cast<std::uint32_t>(c[1]) << 8 |
           static_cast<std::uint32_t>(c[2]) << 16;
  }
  static bool fits(const cv::Mat& image, const cv::Mat& depth, int type) {
    return !image.empty() && image.type() == type && image.size() == depth.size();
  }

  void begin(std::size_t points) {
    sub_bits_ = 12;
    while (sub_bits_ > 2 && points >> (32 - sub_bits_) != 0) --sub_bits_;
    per_unit_ = static_cast<float>(static_cast<double>(1 << sub_bits_) / leaf_m_);
    voxels_ = 0;
    outside_ = 0;
    if (table_.empty()) resize_table(16);
    reserve_block();
  }
  void read_tile(const DepthSource& source, const cv::Rect& tile, bool coloured) {
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
  static void read_colours(const cv::Mat& bgr, int y, int x0, int n, std::uint32_t* out) {
    if (bgr.type() == CV_8UC1) {
      const std::uint8_t* grey = bgr.ptr<std::uint8_t>(y) + x0;
      for (int k = 0; k < n; ++k) out[k] = grey[k] * 0x010101U;
      return;
    }
    const cv::Vec3b* colours = bgr.ptr<cv::Vec3b>(y) + x0;
    for (int k = 0; k < n; ++k) out[k] = packed(colours[k]);
  }
  void add_block(bool coloured) {
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
  void insert() {
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

  /// Reserves space for the voxels that one block may add. Entry 0 means "none".
  void reserve_block() {
    const std::size_t needed = std::size_t{voxels_} + detail::PointBlock::kSize + 1;
    if (needed <= sums_.size()) return;
    const std::size_t size = needed + needed / 2;
    keys_.resize(size);
    sums_.resize(size);
    colours_.resize(size);
  }
  void resize_table(int bits) {
    bits_ = bits;
    table_.assign(std::size_t{1} << bits, 0);
    const std::uint32_t mask = static_cast<std::uint32_t>(table_.size()) - 1;
    for (std::uint32_t j = 1; j <= voxels_; ++j) {
      std::uint32_t place = VoxelKey::place(keys_[j], bits_);
      while (table_[place] != 0) place = (place + 1) & mask;
      table_[place] = j;
    }
  }
  void finish(bool coloured, std::vector<VoxelPoint>& out) {
    out.resize(voxels_);
    dynfilter::detail::call_widest([&](auto) DYNFILTER_AS_CALLER { write_voxels(coloured, out.data()); });
    std::memset(table_.data(), 0, table_.size() * sizeof(table_[0]));
    const bool far_too_large = bits_ > 16 && std::size_t{voxels_} * 32 < table_.size();
    voxels_ = 0;
    if (far_too_large) resize_table(bits_ - 1);
  }
  void write_voxels(bool coloured, VoxelPoint* out) const {
    const detail::CentroidScale scale{leaf_m_ / (1 << sub_bits_), static_cast<double>(1 << sub_bits_)};
    for (std::uint32_t j = 1; j <= voxels_; ++j)
      detail::write_centroid(sums_[j], keys_[j], scale, out[j - 1]);
    if (!coloured) return;
    for (std::uint32_t j = 1; j <= voxels_; ++j) detail::write_colour(colours_[j], out[j - 1]);
  }

  double leaf_m_ = 0.02;
  float per_unit_ = 0;
  int sub_bits_ = 12, bits_ = 0;
  std::uint32_t voxels_ = 0;
  std::size_t outside_ = 0;
  std::vector<std::uint32_t> table_;  ///< index of a voxel, 0: free
  std::vector<std::uint64_t> keys_;   ///< of the voxels, from index 1
  std::vector<detail::FourSums> sums_, colours_;
  detail::PointBlock block_;
  detail::KeyedBlock keyed_;
};

namespace detail {}  // namespace detail

}  // namespace dynfilter::mapping
