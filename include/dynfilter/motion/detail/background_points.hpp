// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/cells.hpp>
#include <dynfilter/core/cpu.hpp>
#include <dynfilter/core/point_grid.hpp>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/core/simd.hpp>
#include <dynfilter/core/span.hpp>
#include <dynfilter/geometry/depth_noise.hpp>
#include <dynfilter/geometry/undistort.hpp>
#include <dynfilter/motion/row_twist.hpp>
#include <opencv2/core.hpp>
#include <optional>
#include <tuple>
#include <vector>

namespace dynfilter {

/// What a background motion is estimated from. One entry per feature in every span but `seeds`.
struct RigidBackgroundScene {
  static constexpr float kMobile = 0.5F;  ///< mobility from which on a point counts as having moved

  Camera camera;
  Span<const cv::Point3f> reference_m, current_m;  ///< in the camera frames; z not finite: no point
  Span<const cv::Point2f> pixels;                  ///< current positions of the features
  Span<const float> mobility;                      ///< probability of having moved recently; empty: unknown
  Span<const int> seeds;                           ///< features that may be used, ascending
  std::optional<Pose> expected;                    ///< T_current_reference of a camera with constant velocity
  double elapsed_s = 0;                            ///< since the reference; 0: not known
  std::optional<Eigen::Vector3d> last_turn_radps;  ///< rate of turn of T_current_reference in the last step
  std::optional<Pose> predicted;                   ///< T_current_reference of the host
  std::optional<MotionPrior> prior;                ///< from sensors beside the camera
  double prior_wrong = 0;                          ///< probability; from 0.5 on it is compared only
  DepthNoise depth_noise{};                        ///< of the sensor
  /// Whole error of a static match over the noise that neighbours do not share.
  double noise_ratio = 1.5;
};

namespace detail {

/// The points that a background motion is estimated from: the farthest four seeds of each cell of a 16 x 12
/// grid. So a dense mover does not outvote its surroundings, and the work does not grow with the features.
/// Columns of coordinates, farthest point first, padded to whole packs. Cost: O(seeds).
class BackgroundPoints {
 public:
  static constexpr int kColumns = 16, kRows = 12;
  static constexpr std::size_t kCells = static_cast<std::size_t>(kColumns) * kRows;

  /// `scene` must outlive the use of this object until the next call.
  void sample(const RigidBackgroundScene& scene) {
    scene_ = &scene;
    fill_cells();
    collect();
    lay_out();
    set_depth_noise(scene.depth_noise);
  }

  /// Points of the scene have moved. The same features take part.
  void follow(const RigidBackgroundScene& scene) {
    scene_ = &scene;
    lay_out();
    set_depth_noise(scene.depth_noise);
  }

  std::size_t size() const { return features_.size(); }
  /// size(), padded to whole packs: the length of a row of residuals.
  std::size_t stride() const { return stride_; }
  /// Indices of the features, farthest first.
  const std::vector<int>& features() const { return features_; }
  const cv::Point3f& reference_m(std::size_t k) const { return scene_->reference_m[feature(k)]; }
  const cv::Point3f& current_m(std::size_t k) const { return scene_->current_m[feature(k)]; }
  const cv::Point2f& pixel(std::size_t k) const { return scene_->pixels[feature(k)]; }
  float depth_m(std::size_t k) const { return column(kDepth)[k]; }
  float mobility(std::size_t k) const { return scene_->mobility.empty() ? 0 : scene_->mobility[feature(k)]; }
  bool moved_recently(std::size_t k) const { return !(mobility(k) < RigidBackgroundScene::kMobile); }
  /// Row-major index of a cell of the grid.
  std::size_t cell(std::size_t k) const { return cells_of_[k]; }

  /// The noise of both depths, for measure().
  void set_depth_noise(const DepthNoise& noise) {
    float* variance = column(kVariance);
    for (std::size_t k = 0; k < size(); ++k) {
      const auto now = static_cast<float>(noise.sigma_m(current_m(k).z)),
                 then = static_cast<float>(noise.sigma_m(reference_m(k).z));
      variance[k] = now * now + then * then;
    }
  }

  /// Squared residuals under a motion: in the image [px^2], and in depth in units of its variance.
  /// Both rows have stride() entries.
  void measure(const Pose& T_current_reference, float* image2_px2, float* depth2) const {
    const PointMotion T(T_current_reference);
    const auto fx = static_cast<float>(scene_->camera.fx_px), fy = static_cast<float>(scene_->camera.fy_px);
    for (std::size_t k = 0; k < stride_; k += Pack::kWidth) {
      const Pack x = pack(kX, k), y = pack(kY, k), z = pack(kZ, k);
      const auto moved = [&](int row) {
        return T.R[row][0] * x + (T.R[row][1] * y + T.R[row][2] * z) + T.t[row];
      };
      const Pack qz = moved(2);
      const Pack u = fx * (moved(0) / qz - pack(kU, k)), v = fy * (moved(1) / qz - pack(kV, k));
      const Pack deeper = qz - pack(kDepth, k);
      where_positive(qz, u * u + v * v, kBehind_px2).store(image2_px2 + k);
      (deeper * deeper / pack(kVariance, k)).store(depth2 + k);
    }
  }

  /// Points then (p) and now (u = x/z, v = y/z, z), with what RowTwistFit needs.
  template <class P>
  struct PointPack {
    P p[3], u, v, z, depth_m2, s, weight;
  };
  template <class P, class F>
  DYNFILTER_AS_CALLER void for_each_pack(const F& visit) const {
    for (std::size_t k = 0; k < stride_; k += Pack::kWidth)
      visit(PointPack<P>{{pack<P>(kX, k), pack<P>(kY, k), pack<P>(kZ, k)},
                         pack<P>(kU, k),
                         pack<P>(kV, k),
                         pack<P>(kDepth, k),
                         pack<P>(kVariance, k),
                         pack<P>(kRow, k),
                         pack<P>(kStill, k)});
  }

 private:
  /// x, y, z then; x/z, y/z, z now; row; 1: did not move recently.
  enum Column { kX, kY, kZ, kU, kV, kDepth, kVariance, kRow, kStill, kCount };
  static constexpr std::size_t kPerCell = 4;
  static constexpr float kBehind_px2 = 1e9F;  ///< residual of a point behind the camera

  struct Candidate {
    float depth_m;  ///< beside the index, so that sorting does not look it up
    int index;
  };

  static bool usable(const cv::Point3f& p) {
    return valid_depth(p.z) && std::isfinite(p.x) && std::isfinite(p.y);
  }
  std::size_t cell_at(const cv::Point2f& px) const {
    const ImageCells<double> cells{2 * scene_->camera.cx_px, 2 * scene_->camera.cy_px, kColumns, kRows};
    return static_cast<std::size_t>(cells.of(px.x, px.y));
  }

  void fill_cells() {
    cells_.build(kCells, scene_->seeds.size(), [&](std::size_t seed) {
      const auto k = static_cast<std::size_t>(scene_->seeds[seed]);
      return k < scene_->pixels.size() && usable(scene_->reference_m[k]) && usable(scene_->current_m[k]) &&
                     PointGrid::usable(scene_->pixels[k])
                 ? cell_at(scene_->pixels[k])
                 : CellLists::kNoCell;
    });
  }
  void collect() {
    const auto farther_first = [&](const Candidate& a, const Candidate& b) { return farther(a, b); };
    candidates_.clear();
    candidates_.reserve(scene_->seeds.size());
    for (std::size_t c = 0; c < kCells; ++c) {
      const std::size_t first = candidates_.size(), most = first + kPerCell;
      for (const std::int32_t seed : cells_[c]) {
        const int i = scene_->seeds[static_cast<std::size_t>(seed)];
        candidates_.push_back({scene_->current_m[static_cast<std::size_t>(i)].z, i});
      }
      if (candidates_.size() <= most) continue;
      const auto begin = candidates_.begin() + static_cast<std::ptrdiff_t>(first);
      std::partial_sort(begin, begin + kPerCell, candidates_.end(), farther_first);
      candidates_.resize(most);
    }
    std::sort(candidates_.begin(), candidates_.end(), farther_first);
  }
  /// Ties are decided by position, so that the order of the features does not matter.
  bool farther(const Candidate& a, const Candidate& b) const {
    if (a.depth_m != b.depth_m) return a.depth_m > b.depth_m;
    const auto key = [&](int i) {
      const auto k = static_cast<std::size_t>(i);
      const cv::Point2f& now = scene_->pixels[k];
      const cv::Point3f& then = scene_->reference_m[k];
      return std::make_tuple(now.y, now.x, then.z, then.y, then.x, i);
    };
    return key(a.index) < key(b.index);
  }

  void lay_out() {
    features_.clear();
    cells_of_.clear();
    for (const Candidate& candidate : candidates_) features_.push_back(candidate.index);
    stride_ = (size() + Pack::kWidth - 1) / Pack::kWidth * Pack::kWidth;
    columns_.assign(kCount * stride_, 1);  // padding: any point in front of the camera
    std::fill_n(column(kStill), stride_, 0.0F);
    for (std::size_t k = 0; k < size(); ++k) {
      const cv::Point3f &p = reference_m(k), &c = current_m(k);
      column(kX)[k] = p.x, column(kY)[k] = p.y, column(kZ)[k] = p.z;
      column(kU)[k] = c.x / c.z, column(kV)[k] = c.y / c.z, column(kDepth)[k] = c.z;
      column(kRow)[k] = static_cast<float>(RowTwist::row(scene_->camera, pixel(k).y));
      column(kStill)[k] = moved_recently(k) ? 0 : 1;
      cells_of_.push_back(cell_at(pixel(k)));
    }
  }

  std::size_t feature(std::size_t k) const { return static_cast<std::size_t>(features_[k]); }
  float* column(int c) { return columns_.data() + static_cast<std::size_t>(c) * stride_; }
  const float* column(int c) const { return columns_.data() + static_cast<std::size_t>(c) * stride_; }
  template <class P = Pack>
  DYNFILTER_AS_CALLER P pack(int c, std::size_t k) const {
    return P::load(column(c) + k);
  }

  const RigidBackgroundScene* scene_ = nullptr;
  CellLists cells_;  ///< of the seeds
  std::vector<Candidate> candidates_;
  std::vector<int> features_;
  std::vector<std::size_t> cells_of_;
  std::size_t stride_ = 0;
  std::vector<float> columns_;  ///< kCount x stride_
};

}  // namespace detail
}  // namespace dynfilter
