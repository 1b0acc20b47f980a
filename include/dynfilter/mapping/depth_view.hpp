// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/cpu.hpp>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/core/simd.hpp>
#include <dynfilter/geometry/depth_noise.hpp>
#include <dynfilter/geometry/undistort.hpp>
#include <dynfilter/mapping/map_params.hpp>
#include <dynfilter/mapping/voxel_key.hpp>
#include <dynfilter/mapping/voxel_map.hpp>
#include <limits>
#include <opencv2/core.hpp>
#include <vector>

namespace dynfilter::mapping {

/// What a keyframe's depth image shows at places in the world: a surface, or free space. Stored compactly: 6
/// bytes per 4 x 4 pixels, 115 KB for 640 x 480. A place is seen through if all depths within 4 to 8 pixels
/// are behind it by more than the margin and the noise. Therefore no place at a silhouette, on a grazing
/// surface, beside pixels without depth or at the image's edge is ever seen through. In doubt, points stay.
class DepthView {
 public:
  static constexpr int kBlockBits = 2, kBlockPx = 1 << kBlockBits;

  /// `depth_m`: CV_32FC1, 0: no depth. `moving`: CV_8UC1 of its size, not 0: moving.
  /// Moving pixels show free space in front of them, but no static surface.
  void build(const cv::Mat& depth_m, const cv::Mat& moving, const Camera& camera);
  std::size_t bytes() const { return blocks_.capacity() * sizeof(Block); }

  /// Calls f(index, seen, through) for the voxels of a map from `begin`. At most one of the two is 1, the
  /// other is 0. Skips batches that are certainly out of view. `leaf_m`: leaf of the map's level. The result
  /// depends only on the voxel's key, the view and its pose, so votes can be undone. Cost: about 5 ns per
  /// voxel, and almost nothing for a batch out of view.
  template <class F>
  void visit(const KeyList& keys, std::size_t begin, double leaf_m, const Pose& T_world_camera,
             const F& f) const {
    const Pose T = inverse(T_world_camera);
    const Sight sight(*this, leaf_m, T);
    Projected voxels;
    for (std::size_t i = begin, end = 0; i < keys.size(); i = end) {
      end = std::min(keys.size(), (i / kAtOnce + 1) * kAtOnce);
      if (!sight.may_reach(keys.box_of(i))) continue;
      look(keys.keys().data() + i, end - i, leaf_m, T, voxels);
      for (std::size_t k = 0; k < end - i; ++k) f(i + k, voxels.seen[k], voxels.through[k]);
    }
  }

 private:
  static constexpr std::size_t kAtOnce = KeyList::kBatch;
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

  /// The space that a view can judge: a pyramid in front of the camera, limited by the measured depths and
  /// the noise at that distance.
  class Sight {
   public:
    Sight(const DepthView& view, double leaf_m, const Pose& T);  ///< of a camera at T_camera_world

    /// Never false for a box with a voxel that look() judges. slack_m is much larger than rounding.
    bool may_reach(const CellBox& box) const;

   private:
    /// True if z exceeds every depth by more than the noise.
    /// It then also holds between two such distances, because the noise grows quadratically.
    bool beyond_all(double z) const {
      return z - view_.farthest_m_ > margin_m_ + CarveParams::kNoiseSigmas * DepthNoise().sigma_m(z) + 0.01;
    }

    const DepthView& view_;
    double leaf_m_;
    Eigen::Matrix3d R_;
    Eigen::Vector3d t_;
    double margin_m_, left_, right_, top_, bottom_;
  };

  std::size_t at(int bx, int by) const {
    return static_cast<std::size_t>(by) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(bx);
  }
  static std::uint16_t in_units(double m) {
    return static_cast<std::uint16_t>(std::clamp(m / kUnitM, 1.0, 65535.0));
  }

  /// `own`: smallest depth of the block minus its noise; 0 if a quarter of the block has no depth.
  void summarise(const cv::Mat& depth_m, const cv::Mat& moving, int bx, int by,
                 std::vector<std::uint16_t>& own);
  std::uint16_t nearest_around(const std::vector<std::uint16_t>& own, int bx, int by) const;

  /// noinline: all callers must compute identical results.
  void look(const std::uint64_t* keys, std::size_t n, double leaf_m, const Pose& T, Projected& voxels) const;

  /// Centres of voxels in the camera frame.
  static void transform(const std::uint64_t* keys, std::size_t n, float leaf_m, const Pose& T,
                        Projected& out);

  /// Block of each voxel in the image. Voxels out of view use the last block, which is unknown.
  template <class L>
  void find_blocks(std::size_t n, Projected& voxels) const;
  double widest() const { return 1.25 * (columns_ * kBlockPx + 16) / camera_.fx_px; }
  double tallest() const { return 1.25 * (rows_ * kBlockPx + 16) / camera_.fy_px; }
  /// Moves the points to the pixels of the distorted image.
  /// Skips points more than a quarter of the image outside, where the polynomial may turn back.
  void distort(std::size_t n, Projected& voxels) const;

  /// Branchless, because the outcomes are unpredictable.
  void judge(std::size_t n, double leaf_m, Projected& voxels) const;

  Camera camera_;
  int columns_ = 0, rows_ = 0;
  double farthest_m_ = 0;
  std::vector<Block> blocks_ = std::vector<Block>(1);  ///< plus one block for voxels out of view
};

inline void DepthView::build(const cv::Mat& depth_m, const cv::Mat& moving, const Camera& camera) {
  camera_ = camera;
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

inline DepthView::Sight::Sight(const DepthView& view, double leaf_m, const Pose& T)
    : view_(view), leaf_m_(leaf_m), R_(T.R()), t_(T.t()), margin_m_(CarveParams::kMargin_m + leaf_m) {
  const Camera& c = view.camera_;
  const double width = view.columns_ * kBlockPx, height = view.rows_ * kBlockPx;
  left_ = -(c.cx_px + 0.5) / c.fx_px, right_ = left_ + width / c.fx_px;
  top_ = -(c.cy_px + 0.5) / c.fy_px, bottom_ = top_ + height / c.fy_px;
  if (!c.distorted()) return;
  right_ = view.widest(), left_ = -right_;
  bottom_ = view.tallest(), top_ = -bottom_;
}

inline bool DepthView::Sight::may_reach(const CellBox& box) const {
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
    own[b] = in_units(z - CarveParams::kNoiseSigmas * DepthNoise().sigma_m(z));
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

inline __attribute__((noinline)) void DepthView::look(const std::uint64_t* keys, std::size_t n, double leaf_m,
                                                      const Pose& T, Projected& voxels) const {
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
             margin_m = static_cast<float>(CarveParams::kMargin_m + kHalfDiagonal * leaf_m),
             sigmas = static_cast<float>(CarveParams::kNoiseSigmas);
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

namespace detail {

inline void make_vote_permanent(std::uint16_t& live, std::uint16_t& old, int vote) {
  live = static_cast<std::uint16_t>(live - vote);
  old = static_cast<std::uint16_t>(std::min(65535, old + vote));
}

}  // namespace detail

/// Adds (sign 1) or removes (-1) what a view says of the voxels from `begin` on: a surface, or seen through.
inline void add_votes(VoxelMap& map, const DepthView& view, const Pose& T_world_camera, std::size_t begin,
                      double leaf_m, int sign) {
  std::vector<VoxelVotes>& votes = map.votes();
  view.visit(map.key_list(), begin, leaf_m, T_world_camera, [&](std::size_t i, int seen, int through) {
    votes[i].seen = static_cast<std::uint16_t>(votes[i].seen + sign * seen);
    votes[i].through = static_cast<std::uint16_t>(votes[i].through + sign * through);
  });
}

/// Moves a view's votes to the permanent counters, from which nothing is removed.
inline void make_votes_permanent(VoxelMap& map, const DepthView& view, const Pose& T_world_camera,
                                 double leaf_m) {
  std::vector<VoxelVotes>& votes = map.votes();
  view.visit(map.key_list(), 0, leaf_m, T_world_camera, [&](std::size_t i, int seen, int through) {
    detail::make_vote_permanent(votes[i].seen, votes[i].old_seen, seen);
    detail::make_vote_permanent(votes[i].through, votes[i].old_through, through);
  });
}

}  // namespace dynfilter::mapping
