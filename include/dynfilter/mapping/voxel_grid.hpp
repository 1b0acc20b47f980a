// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <dynfilter/core/cpu.hpp>
#include <dynfilter/core/error.hpp>
#include <dynfilter/core/span.hpp>
#include <dynfilter/mapping/depth_points.hpp>
#include <dynfilter/mapping/point_block.hpp>
#include <dynfilter/mapping/voxel_key.hpp>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
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
  using Four = std::uint32_t __attribute__((vector_size(16)));
  Four v{};

  /// Adds four 16-bit numbers.
  void add(std::uint64_t summand);
};

/// A grid's quantum, and the conversion from sums of quanta to metres.
struct CentroidScale {
  double unit_m, units_per_leaf;
};

/// Half a quantum compensates the floor of each coordinate.
DYNFILTER_AS_CALLER inline void write_centroid(const FourSums& sums, std::uint64_t key,
                                               const CentroidScale& scale, VoxelPoint& out) {
  using FourInts = std::int32_t __attribute__((vector_size(16)));
  using FourFloats = float __attribute__((vector_size(16)));
  using FourDoubles = double __attribute__((vector_size(32)));
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

/// The voxel grid of RTS-SLAM (eq. 15-19): voxel v = floor(p / leaf).
/// The result has one point per voxel, the centroid of its points.
/// Coordinates are summed as integer multiples of leaf / 4096.
/// The sums are exact and do not depend on the points' order.
/// The error of a centroid is at most this quantum.
/// Above 2^20 points, the quantum doubles with each doubling.
/// Voxels are in the order in which points first reach them. Classes are kept apart.
///
/// Cost: linear. A voxel grid is memory-bound,
/// because each point accesses a table larger than the caches.
/// Keys of 256 points are therefore computed together and their table entries are prefetched.
/// The table holds only 4-byte indices.
/// A new voxel is created without a branch, which would be unpredictable at small leaves.
/// Buffers are reused.
class VoxelGrid {
 public:
  /// Throws ConfigError unless 1e-4 m <= leaf_m <= 1e3 m.
  explicit VoxelGrid(double leaf_m = 0.02);

  void set_leaf(double leaf_m);
  double leaf_m() const { return leaf_m_; }

  /// Skips points that are not finite or beyond 131072 leaves from the origin.
  /// `colours` may be empty.
  void run(Span<const cv::Point3f> points_m, Span<const cv::Vec3b> colours, std::vector<VoxelPoint>& out);

  /// Reads a depth image directly, without intermediate points.
  /// Images of other types or sizes than the depth image are ignored.
  /// Without rays of that size the result is empty.
  void run(const DepthSource& source, std::vector<VoxelPoint>& out);

  /// Points of the last run that were too far from the origin or not finite.
  std::size_t outside() const { return outside_; }

 private:
  static constexpr int kTileColumns = 32, kTileRows = 8;
  static constexpr int kFar = detail::KeyedBlock::kFar, kNear = detail::KeyedBlock::kNear;
  static_assert(kTileColumns * kTileRows == detail::PointBlock::kSize);
  using Four = detail::FourSums::Four;

  static std::uint32_t packed(const cv::Vec3b& c);
  static bool fits(const cv::Mat& image, const cv::Mat& depth, int type) {
    return !image.empty() && image.type() == type && image.size() == depth.size();
  }

  void begin(std::size_t points);

  void read_tile(const DepthSource& source, const cv::Rect& tile, bool coloured);
  static void read_colours(const cv::Mat& bgr, int y, int x0, int n, std::uint32_t* out);

  void add_block(bool coloured);

  template <bool kColoured>
  void insert();

  /// Reserves space for the voxels that one block may add. Entry 0 means "none".
  void reserve_block();
  void resize_table(int bits);

  void finish(bool coloured, std::vector<VoxelPoint>& out);

  void write_voxels(bool coloured, VoxelPoint* out) const;

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

}  // namespace dynfilter::mapping

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/mapping/detail/voxel_grid-inl.hpp>
#endif
