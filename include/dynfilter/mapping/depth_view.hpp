// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/geometry/depth_noise.hpp>
#include <dynfilter/geometry/undistort.hpp>
#include <dynfilter/mapping/map_params.hpp>
#include <dynfilter/mapping/voxel_map.hpp>
#include <opencv2/core.hpp>
#include <vector>

namespace dynfilter::mapping {

/// What a keyframe's depth image says of places in the world, kept small (12 bytes per 4 x 4 pixels, 115 KB
/// for 640 x 480): was a surface seen there, or was it seen through? Through: the place lies in front of
/// everything that was measured within 4 to 8 pixels around, by more than the margin and the noise. So no
/// place at a silhouette, on a grazing surface, beside pixels without depth or at the image's edge is ever
/// seen through: doubt keeps points.
class DepthView {
 public:
  static constexpr int kBlockPx = 4;
  enum class Sight : std::uint8_t { Nothing, Seen, Through };

  /// `depth_m`: CV_32FC1, 0 = none. `moving`: CV_8UC1 of its size, not 0 = moves: such pixels show free space
  /// in front of them, but no static surface.
  void build(const cv::Mat& depth_m, const cv::Mat& moving, const Camera& camera, const CarveParams& params) {
    camera_ = camera;
    params_ = params;
    columns_ = depth_m.cols / kBlockPx;
    rows_ = depth_m.rows / kBlockPx;
    const std::size_t n = static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_);
    nearest_.assign(n, 0);
    low_.assign(n, 0);
    high_.assign(n, 0);
    std::vector<std::uint16_t> own(n);
    for (int by = 0; by < rows_; ++by)
      for (int bx = 0; bx < columns_; ++bx) summarise(depth_m, moving, bx, by, own);
    for (int by = 1; by + 1 < rows_; ++by)
      for (int bx = 1; bx + 1 < columns_; ++bx) nearest_[at(bx, by)] = nearest_around(own, bx, by);
  }
  std::size_t bytes() const {
    return (nearest_.capacity() + low_.capacity() + high_.capacity()) * sizeof(nearest_[0]);
  }

  /// For voxels `begin` to `end` of a map: f(index, Seen or Through). `leaf_m`: of the map's level. A pure
  /// function of the voxel's key, the view and its pose, so that votes can be taken back. Cost: a few
  /// nanoseconds a voxel out of view.
  template <class F>
  void visit(const std::vector<std::uint64_t>& keys, std::size_t begin, std::size_t end, double leaf_m,
             const Pose& T_world_camera, const F& f) const {
    const Pose T = inverse(T_world_camera);
    Projected block;
    for (std::size_t i = begin; i < end; i += kAtOnce) {
      const std::size_t n = std::min(kAtOnce, end - i);
      transform(keys.data() + i, n, leaf_m, T, block);
      for (std::size_t k = 0; k < n; ++k) {
        if (block.inside[k] == 0) continue;
        const Sight sight = look(block.x[k], block.y[k], block.z[k], leaf_m);
        if (sight != Sight::Nothing) f(i + k, sight);
      }
    }
  }

  /// A point in the camera frame [m].
  Sight look(float x, float y, float z, double leaf_m) const {
    if (!(z > 0)) return Sight::Nothing;
    cv::Point2f px(static_cast<float>(camera_.fx_px) * x / z + static_cast<float>(camera_.cx_px),
                   static_cast<float>(camera_.fy_px) * y / z + static_cast<float>(camera_.cy_px));
    px = distort_point(camera_, px) + cv::Point2f(0.5F, 0.5F);
    if (!(px.x >= 0 && px.y >= 0 && px.x < static_cast<float>(columns_ * kBlockPx) &&
          px.y < static_cast<float>(rows_ * kBlockPx)))
      return Sight::Nothing;
    const std::size_t b = at(static_cast<int>(px.x) / kBlockPx, static_cast<int>(px.y) / kBlockPx);
    const double depth_m = static_cast<double>(z), margin_m = params_.margin_m + kHalfDiagonal * leaf_m;
    if (nearest_[b] > 0 && depth_m + margin_m < nearest_[b] * kUnitM) return Sight::Through;
    const double reach_m = margin_m + params_.noise_sigmas * DepthNoise().sigma_m(depth_m);
    const bool seen = low_[b] > 0 && (std::abs(depth_m - low_[b] * kUnitM) <= reach_m ||
                                      std::abs(depth_m - high_[b] * kUnitM) <= reach_m);
    return seen ? Sight::Seen : Sight::Nothing;
  }

 private:
  static constexpr std::size_t kAtOnce = 256;
  static constexpr double kUnitM = 0.001, kHalfDiagonal = 0.866;
  struct Projected {
    float x[kAtOnce], y[kAtOnce], z[kAtOnce];
    std::int32_t inside[kAtOnce];
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
      low_[b] = in_units(static_cast<double>(low)), high_[b] = in_units(static_cast<double>(high));
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

  /// Centres of voxels in the camera frame, and whether they are about in view. One function for all callers:
  /// what it computes must be equal each time.
  __attribute__((noinline)) void transform(const std::uint64_t* keys, std::size_t n, double leaf_m,
                                           const Pose& T, Projected& out) const {
    const auto leaf = static_cast<float>(leaf_m);
    float m[12];
    for (std::size_t r = 0; r < 3; ++r) {
      for (std::size_t c = 0; c < 3; ++c) m[4 * r + c] = static_cast<float>(T.rotation[3 * r + c]);
      m[4 * r + 3] = static_cast<float>(T.translation_m[r]);
    }
    // 8 px and a quarter more than the image, for distortion.
    const float wide = 1.25F * static_cast<float>((columns_ * kBlockPx + 16) / camera_.fx_px);
    const float tall = 1.25F * static_cast<float>((rows_ * kBlockPx + 16) / camera_.fy_px);
    for (std::size_t k = 0; k < n; ++k) {
      const float wx = (static_cast<float>(VoxelKey::axis(keys[k], 0)) + 0.5F) * leaf;
      const float wy = (static_cast<float>(VoxelKey::axis(keys[k], 1)) + 0.5F) * leaf;
      const float wz = (static_cast<float>(VoxelKey::axis(keys[k], 2)) + 0.5F) * leaf;
      const float x = m[0] * wx + m[1] * wy + m[2] * wz + m[3];
      const float y = m[4] * wx + m[5] * wy + m[6] * wz + m[7];
      const float z = m[8] * wx + m[9] * wy + m[10] * wz + m[11];
      out.x[k] = x, out.y[k] = y, out.z[k] = z;
      out.inside[k] = static_cast<int>(z > 0) & static_cast<int>(std::abs(x) < wide * z) &
                      static_cast<int>(std::abs(y) < tall * z);
    }
  }

  Camera camera_;
  CarveParams params_;
  int columns_ = 0, rows_ = 0;
  std::vector<std::uint16_t> nearest_, low_, high_;  ///< millimetres, 0: unknown
};

}  // namespace dynfilter::mapping
