// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/mapping/depth_view.hpp>

#include <cmath>
#include <dynfilter/core/inline.hpp>
#include <dynfilter/core/lanes.hpp>
#include <dynfilter/geometry/undistort.hpp>
#include <dynfilter/mapping/voxel_key.hpp>
#include <limits>
#include <opencv2/core.hpp>

namespace dynfilter::mapping {

DYNFILTER_INLINE void DepthView::build(const cv::Mat& depth_m, const cv::Mat& moving, const Camera& camera,
                                       const CarveParams& params) {
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
  farthest_m_ = 0;
  for (const Block& block : blocks_)
    farthest_m_ = std::max(farthest_m_, kUnitM * std::max(block.nearest, block.high));
}

DYNFILTER_INLINE DepthView::Sight::Sight(const DepthView& view, double leaf_m, const Pose& T)
    : view_(view), leaf_m_(leaf_m), R_(T.R()), t_(T.t()), margin_m_(view.params_.margin_m + leaf_m) {
  const Camera& c = view.camera_;
  const double width = view.columns_ * kBlockPx, height = view.rows_ * kBlockPx;
  left_ = -(c.cx_px + 0.5) / c.fx_px, right_ = left_ + width / c.fx_px;
  top_ = -(c.cy_px + 0.5) / c.fy_px, bottom_ = top_ + height / c.fy_px;
  if (!c.distorted()) return;
  right_ = view.widest(), left_ = -right_;
  bottom_ = view.tallest(), top_ = -bottom_;
}

DYNFILTER_INLINE bool DepthView::Sight::may_reach(const CellBox& box) const {
  Eigen::Vector3d centre, half;
  for (int a = 0; a < 3; ++a) {
    const auto i = static_cast<std::size_t>(a);
    centre[a] = 0.5 * (static_cast<double>(box.low[i]) + box.high[i] + 1) * leaf_m_;
    half[a] = 0.5 * (static_cast<double>(box.high[i]) - box.low[i]) * leaf_m_;
  }
  const double slack_m = 1e-4 + 1e-5 * (centre.lpNorm<1>() + half.sum() + t_.lpNorm<1>());
  const Eigen::Vector3d p = R_ * centre + t_;
  // Largest value of normal . point in the box.
  const auto most = [&](double x, double y, double z) {
    const Eigen::Vector3d normal(x, y, z);
    return normal.dot(p) + (R_.transpose() * normal).cwiseAbs().dot(half) + slack_m;
  };
  const double far_m = most(0, 0, 1), near_m = -most(0, 0, -1);
  return far_m > 0 && most(1, 0, -left_) >= 0 && most(-1, 0, right_) >= 0 && most(0, 1, -top_) >= 0 &&
         most(0, -1, bottom_) >= 0 && !(beyond_all(std::max(0.0, near_m)) && beyond_all(far_m));
}

inline void DepthView::summarise(const cv::Mat& depth_m, const cv::Mat& moving, int bx, int by,
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

inline std::uint16_t DepthView::nearest_around(const std::vector<std::uint16_t>& own, int bx, int by) const {
  std::uint16_t least = 65535;
  for (int y = by - 1; y <= by + 1; ++y)
    for (int x = bx - 1; x <= bx + 1; ++x) {
      if (own[at(x, y)] == 0) return 0;
      least = std::min(least, own[at(x, y)]);
    }
  return least;
}

DYNFILTER_INLINE __attribute__((noinline)) void DepthView::look(const std::uint64_t* keys, std::size_t n,
                                                                double leaf_m, const Pose& T,
                                                                Projected& voxels) const {
  dynfilter::detail::call_widest([&](auto lanes) DYNFILTER_AS_CALLER {
    transform(keys, n, static_cast<float>(leaf_m), T, voxels);
    find_blocks<dynfilter::detail::Lanes<lanes()>>(n, voxels);
    judge(n, leaf_m, voxels);
  });
}

inline DYNFILTER_AS_CALLER void DepthView::transform(const std::uint64_t* keys, std::size_t n, float leaf_m,
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

template <class L>
inline DYNFILTER_AS_CALLER void DepthView::find_blocks(std::size_t n, Projected& voxels) const {
  const auto fx = static_cast<float>(camera_.fx_px), fy = static_cast<float>(camera_.fy_px),
             cx = static_cast<float>(camera_.cx_px) + 0.5F, cy = static_cast<float>(camera_.cy_px) + 0.5F,
             width = static_cast<float>(columns_ * kBlockPx), height = static_cast<float>(rows_ * kBlockPx);
  const typename L::Int none = typename L::Int{} + columns_ * rows_;
  if (camera_.distorted()) distort(n, voxels);
  for (std::size_t k = 0; k < n; k += L::kCount) {
    typename L::Float u, v, z;
    typename L::Int column, row;
    dynfilter::detail::load_lane(voxels.x + k, u);
    dynfilter::detail::load_lane(voxels.y + k, v);
    dynfilter::detail::load_lane(voxels.z + k, z);
    u = fx * u / z + cx;
    v = fy * v / z + cy;
    const typename L::Int inside = (z > 0) & (u >= 0) & (v >= 0) & (u < width) & (v < height);
    dynfilter::detail::truncate_inside<L>(u, inside, column);
    dynfilter::detail::truncate_inside<L>(v, inside, row);
    const typename L::Int block = (row >> kBlockBits) * columns_ + (column >> kBlockBits);
    dynfilter::detail::store_lane(voxels.block + k, typename L::Int((block & inside) | (none & ~inside)));
  }
}

inline void DepthView::distort(std::size_t n, Projected& voxels) const {
  const auto wide = static_cast<float>(widest()), tall = static_cast<float>(tallest());
  for (std::size_t k = 0; k < n; ++k) {
    const float x = voxels.x[k] / voxels.z[k], y = voxels.y[k] / voxels.z[k];
    voxels.x[k] = std::numeric_limits<float>::quiet_NaN();
    if (!(voxels.z[k] > 0 && std::abs(x) < wide && std::abs(y) < tall)) continue;
    const dynfilter::detail::Distorted d = dynfilter::detail::distort_normalised(
        camera_.distortion, static_cast<double>(x), static_cast<double>(y));
    voxels.x[k] = static_cast<float>(d.x) * voxels.z[k], voxels.y[k] = static_cast<float>(d.y) * voxels.z[k];
  }
}

inline DYNFILTER_AS_CALLER void DepthView::judge(std::size_t n, double leaf_m, Projected& voxels) const {
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
    const int at_surface = static_cast<int>(std::abs(z - static_cast<float>(block.low) * unit_m) <= reach_m) |
                           static_cast<int>(std::abs(z - static_cast<float>(block.high) * unit_m) <= reach_m);
    voxels.through[k] = static_cast<std::uint16_t>(through);
    voxels.seen[k] = static_cast<std::uint16_t>(static_cast<int>(block.low > 0) & at_surface & (through ^ 1));
  }
}

}  // namespace dynfilter::mapping
