// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/cpu.hpp>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/geometry/depth_noise.hpp>
#include <dynfilter/geometry/undistort.hpp>
#include <dynfilter/mapping/lanes.hpp>
#include <dynfilter/mapping/map_params.hpp>
#include <dynfilter/mapping/voxel_map.hpp>
#include <limits>
#include <opencv2/core.hpp>
#include <vector>

namespace dynfilter::mapping {

/// What a keyframe's depth image says of places in the world, kept small (6 bytes per 4 x 4 pixels, 115 KB
/// for 640 x 480): was a surface seen there, or was it seen through? Through: the place lies in front of
/// everything that was measured within 4 to 8 pixels around, by more than the margin and the noise. So no
/// place at a silhouette, on a grazing surface, beside pixels without depth or at the image's edge is ever
/// seen through: doubt keeps points.
class DepthView {
 public:
  static constexpr int kBlockBits = 2, kBlockPx = 1 << kBlockBits;

  /// `depth_m`: CV_32FC1, 0 = none. `moving`: CV_8UC1 of its size, not 0 = moves: such pixels show free space
  /// in front of them, but no static surface.
  void build(const cv::Mat& depth_m, const cv::Mat& moving, const Camera& camera, const CarveParams& params) {
    camera_ = camera;
    params_ = params;
    columns_ = depth_m.cols / kBlockPx;
    rows_ = depth_m.rows / kBlockPx;
    const std::size_t n = static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_);
    blocks_.assign(n + 1, Block());
    std::vector<std::uint16_t> own(n);
    for (int by = 0; by < rows_; ++by)
      for (int bx = 0; bx < columns_; ++bx) summarise(depth_m, moving, bx, by, own);
    for (int by = 1; by + 1 < rows_; ++by)
      for (int bx = 1; bx + 1 < columns_; ++bx) blocks_[at(bx, by)].nearest = nearest_around(own, bx, by);
  }
  std::size_t bytes() const { return blocks_.capacity() * sizeof(Block); }

  /// For voxels `begin` to `end` of a map: f(index, seen, through), of which at most one is 1, the others 0.
  /// `leaf_m`: of the map's level. A pure function of the voxel's key, the view and its pose, so that votes
  /// can be taken back. Cost: about 5 ns a voxel.
  template <class F>
  void visit(const std::vector<std::uint64_t>& keys, std::size_t begin, std::size_t end, double leaf_m,
             const Pose& T_world_camera, const F& f) const {
    const Pose T = inverse(T_world_camera);
    Projected voxels;
    for (std::size_t i = begin; i < end; i += kAtOnce) {
      const std::size_t n = std::min(kAtOnce, end - i);
      look(keys.data() + i, n, leaf_m, T, voxels);
      for (std::size_t k = 0; k < n; ++k) f(i + k, voxels.seen[k], voxels.through[k]);
    }
  }

 private:
  static constexpr std::size_t kAtOnce = 256;
  static constexpr double kUnitM = 0.001, kHalfDiagonal = 0.866;
  /// Millimetres, 0: unknown.
  struct Block {
    std::uint16_t nearest = 0, low = 0, high = 0;
  };
  struct Projected {
    float x[kAtOnce], y[kAtOnce], z[kAtOnce];
    std::int32_t block[kAtOnce];
    std::uint16_t seen[kAtOnce], through[kAtOnce];
  };

  std::size_t at(int bx, int by) const {
    return static_cast<std::size_t>(by) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(bx);
  }
  static std::uint16_t in_units(double m) {
    return static_cast<std::uint16_t>(std::clamp(m / kUnitM, 1.0, 65535.0));
  }

  /// `own`: the block's least depth less its noise; 0 where a quarter of the block has none.
  void summarise(const cv::Mat& depth_m, const cv::Mat& moving, int bx, int by,
                 std::vector<std::uint16_t>& own) {
    int measured = 0, still = 0;
    float nearest = 1e9F, low = 1e9F, high = 0;
    for (int y = by * kBlockPx; y < (by + 1) * kBlockPx; ++y) {
      const float* depths = depth_m.ptr<float>(y) + bx * kBlockPx;
      const std::uint8_t* moves = moving.ptr<std::uint8_t>(y) + bx * kBlockPx;
      for (int k = 0; k < kBlockPx; ++k) {
        const float z = depths[k];
        if (!(z > 0)) continue;
        ++measured;
        nearest = std::min(nearest, z);
        if (moves[k] != 0) continue;
        ++still;
        low = std::min(low, z);
        high = std::max(high, z);
      }
    }
    const std::size_t b = at(bx, by);
    if (measured * 4 >= kBlockPx * kBlockPx * 3) {
      const double z = static_cast<double>(nearest);
      own[b] = in_units(z - params_.noise_sigmas * DepthNoise().sigma_m(z));
    }
    if (still > 0)
      blocks_[b].low = in_units(static_cast<double>(low)),
      blocks_[b].high = in_units(static_cast<double>(high));
  }
  std::uint16_t nearest_around(const std::vector<std::uint16_t>& own, int bx, int by) const {
    std::uint16_t least = 65535;
    for (int y = by - 1; y <= by + 1; ++y)
      for (int x = bx - 1; x <= bx + 1; ++x) {
        if (own[at(x, y)] == 0) return 0;
        least = std::min(least, own[at(x, y)]);
      }
    return least;
  }

  /// One function for all callers: what it computes must be equal each time.
  __attribute__((noinline)) void look(const std::uint64_t* keys, std::size_t n, double leaf_m, const Pose& T,
                                      Projected& voxels) const {
    dynfilter::detail::call_widest([&](auto lanes) DYNFILTER_AS_CALLER {
      transform(keys, n, static_cast<float>(leaf_m), T, voxels);
      find_blocks<detail::Lanes<lanes()>>(n, voxels);
      judge(n, leaf_m, voxels);
    });
  }

  /// Centres of voxels in the camera frame.
  DYNFILTER_AS_CALLER static void transform(const std::uint64_t* keys, std::size_t n, float leaf_m,
                                            const Pose& T, Projected& out) {
    float m[12];
    for (std::size_t r = 0; r < 3; ++r) {
      for (std::size_t c = 0; c < 3; ++c) m[4 * r + c] = static_cast<float>(T.rotation[3 * r + c]);
      m[4 * r + 3] = static_cast<float>(T.translation_m[r]);
    }
    for (std::size_t k = 0; k < n; ++k) {
      const float wx = (static_cast<float>(VoxelKey::axis(keys[k], 0)) + 0.5F) * leaf_m;
      const float wy = (static_cast<float>(VoxelKey::axis(keys[k], 1)) + 0.5F) * leaf_m;
      const float wz = (static_cast<float>(VoxelKey::axis(keys[k], 2)) + 0.5F) * leaf_m;
      out.x[k] = m[0] * wx + m[1] * wy + m[2] * wz + m[3];
      out.y[k] = m[4] * wx + m[5] * wy + m[6] * wz + m[7];
      out.z[k] = m[8] * wx + m[9] * wy + m[10] * wz + m[11];
    }
    std::fill(out.x + n, out.x + kAtOnce, 0.0F);
    std::fill(out.y + n, out.y + kAtOnce, 0.0F);
    std::fill(out.z + n, out.z + kAtOnce, 0.0F);
  }

  /// The block that each is seen in; the last one, which knows nothing, for those out of view.
  template <class L>
  DYNFILTER_AS_CALLER void find_blocks(std::size_t n, Projected& voxels) const {
    const auto fx = static_cast<float>(camera_.fx_px), fy = static_cast<float>(camera_.fy_px),
               cx = static_cast<float>(camera_.cx_px) + 0.5F, cy = static_cast<float>(camera_.cy_px) + 0.5F,
               width = static_cast<float>(columns_ * kBlockPx), height = static_cast<float>(rows_ * kBlockPx);
    const typename L::Int none = typename L::Int{} + columns_ * rows_;
    if (camera_.distorted()) distort(n, voxels);
    for (std::size_t k = 0; k < n; k += L::kCount) {
      typename L::Float u, v, z;
      typename L::Int column, row;
      detail::load_lane(voxels.x + k, u);
      detail::load_lane(voxels.y + k, v);
      detail::load_lane(voxels.z + k, z);
      u = fx * u / z + cx;
      v = fy * v / z + cy;
      const typename L::Int inside = (z > 0) & (u >= 0) & (v >= 0) & (u < width) & (v < height);
      detail::truncate_inside<L>(u, inside, column);
      detail::truncate_inside<L>(v, inside, row);
      const typename L::Int block = (row >> kBlockBits) * columns_ + (column >> kBlockBits);
      detail::store_lane(voxels.block + k, typename L::Int((block & inside) | (none & ~inside)));
    }
  }
  /// Moves the points to where a camera without distortion would see them at the same pixel. What lies a
  /// quarter of the image beside it is not looked at: there the polynomial may turn back.
  void distort(std::size_t n, Projected& voxels) const {
    const float wide = 1.25F * static_cast<float>((columns_ * kBlockPx + 16) / camera_.fx_px),
                tall = 1.25F * static_cast<float>((rows_ * kBlockPx + 16) / camera_.fy_px);
    for (std::size_t k = 0; k < n; ++k) {
      const float x = voxels.x[k] / voxels.z[k], y = voxels.y[k] / voxels.z[k];
      voxels.x[k] = std::numeric_limits<float>::quiet_NaN();
      if (!(voxels.z[k] > 0 && std::abs(x) < wide && std::abs(y) < tall)) continue;
      const dynfilter::detail::Distorted d = dynfilter::detail::distort_normalised(
          camera_.distortion, static_cast<double>(x), static_cast<double>(y));
      voxels.x[k] = static_cast<float>(d.x) * voxels.z[k],
      voxels.y[k] = static_cast<float>(d.y) * voxels.z[k];
    }
  }

  /// Without branches: nobody could predict them.
  DYNFILTER_AS_CALLER void judge(std::size_t n, double leaf_m, Projected& voxels) const {
    const auto unit_m = static_cast<float>(kUnitM),
               margin_m = static_cast<float>(params_.margin_m + kHalfDiagonal * leaf_m),
               sigmas = static_cast<float>(params_.noise_sigmas);
    const DepthNoise noise;
    const auto base_m = static_cast<float>(noise.base_m), per_m = static_cast<float>(noise.quadratic_per_m),
               offset_m = static_cast<float>(noise.offset_m);
    for (std::size_t k = 0; k < n; ++k) {
      const Block block = blocks_[static_cast<std::size_t>(voxels.block[k])];
      const float z = voxels.z[k], away_m = z - offset_m;
      const float reach_m = margin_m + sigmas * (base_m + per_m * (away_m * away_m));
      const int through = static_cast<int>(block.nearest > 0) &
                          static_cast<int>(z + margin_m < static_cast<float>(block.nearest) * unit_m);
      const int at_surface =
          static_cast<int>(std::abs(z - static_cast<float>(block.low) * unit_m) <= reach_m) |
          static_cast<int>(std::abs(z - static_cast<float>(block.high) * unit_m) <= reach_m);
      voxels.through[k] = static_cast<std::uint16_t>(through);
      voxels.seen[k] =
          static_cast<std::uint16_t>(static_cast<int>(block.low > 0) & at_surface & (through ^ 1));
    }
  }

  Camera camera_;
  CarveParams params_;
  int columns_ = 0, rows_ = 0;
  std::vector<Block> blocks_ = std::vector<Block>(1);  ///< and one for what is out of view
};

}  // namespace dynfilter::mapping
