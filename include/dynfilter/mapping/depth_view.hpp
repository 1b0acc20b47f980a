// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/cpu.hpp>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/geometry/depth_noise.hpp>
#include <dynfilter/mapping/key_list.hpp>
#include <dynfilter/mapping/map_params.hpp>
#include <opencv2/core/mat.hpp>
#include <vector>

namespace dynfilter::mapping {

/// What a keyframe's depth image shows at places in the world: a surface, or free space.
/// Stored compactly: 6 bytes per 4 x 4 pixels, 115 KB for 640 x 480.
/// A place is seen through if all depths within 4 to 8 pixels are behind it
/// by more than the margin and the noise.
/// Therefore no place at a silhouette, on a grazing surface, beside pixels without depth
/// or at the image's edge is ever seen through. In doubt, points are kept.
class DepthView {
 public:
  static constexpr int kBlockBits = 2, kBlockPx = 1 << kBlockBits;

  /// `depth_m`: CV_32FC1, 0: no depth. `moving`: CV_8UC1 of its size, not 0: moving.
  /// Moving pixels show free space in front of them, but no static surface.
  void build(const cv::Mat& depth_m, const cv::Mat& moving, const Camera& camera, const CarveParams& params);
  std::size_t bytes() const { return blocks_.capacity() * sizeof(Block); }

  /// Calls f(index, seen, through) for the voxels of a map from `begin`.
  /// At most one of the two is 1, the other is 0.
  /// Skips batches that are certainly out of view. `leaf_m`: leaf of the map's level.
  /// The result depends only on the voxel's key, the view and its pose, so votes can be undone.
  /// Cost: about 5 ns per voxel, and almost nothing for a batch out of view.
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

  /// The space that a view can judge: a pyramid in front of the camera,
  /// limited by the measured depths and the noise at that distance.
  class Sight {
   public:
    Sight(const DepthView& view, double leaf_m, const Pose& T);

    /// Never false for a box with a voxel that look() judges. slack_m is much larger than rounding.
    bool may_reach(const CellBox& box) const;

   private:
    /// True if z exceeds every depth by more than the noise.
    /// It then also holds between two such distances, because the noise grows quadratically.
    bool beyond_all(double z) const {
      return z - view_.farthest_m_ > margin_m_ + view_.params_.noise_sigmas * DepthNoise().sigma_m(z) + 0.01;
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
  CarveParams params_;
  int columns_ = 0, rows_ = 0;
  double farthest_m_ = 0;
  std::vector<Block> blocks_ = std::vector<Block>(1);  ///< plus one block for voxels out of view
};

}  // namespace dynfilter::mapping

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/mapping/detail/depth_view-inl.hpp>
#endif
