// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <dynfilter/core/cells.hpp>
#include <dynfilter/geometry/sampling.hpp>
#include <dynfilter/motion/view_motion.hpp>
#include <dynfilter/motion/view_motion_fit.hpp>
#include <optional>
#include <utility>
#include <vector>

namespace dynfilter {

/// What a prior says of the camera's turn over the pairs' gap.
struct ViewTurn {
  std::array<double, 3> rotation_rad{};  ///< as of ViewMotion
  double sigma_rad = 0;                  ///< of each axis
};

/// Limits of the search.
struct ViewMotionOptions {
  double max_distance_px = 1.0;       ///< of an inlier to its epipolar line
  int iterations = 100;               ///< samples of six points, at most
  int min_pairs = 12, min_cells = 5;  ///< with fewer points, or on fewer cells, there is no motion
  /// A turn alone is taken where it has this share of the support, unless more than `parallax_share` of what
  /// it explains flows as parallax does.
  double rotation_share = 0.7, parallax_share = 0.4;
  /// A camera is still if this share of the votes does not flow. Far points alone are fewer, and a car ahead
  /// is one of many cells.
  double rest_share = 0.2;
};

/// The camera's motion from the flow of points of which many may move. The motion whose inliers **cover most
/// of the image** wins, not the one with most inliers. Each of the image's cells has one vote, which its
/// points share. A car with 80 % of the points on a third of the image loses. RANSAC over cells, Gauss-Newton
/// on samples of six points from different cells, Torr and Zisserman's truncated quadratic as support. The
/// last frame's motion is one more hypothesis. Points must flow as in front of both cameras. Where a rotation
/// is supported as well, there is no baseline. Cost: about 0.5 ms for 1000 points. Deterministic; `pairs` in
/// another order may give another motion within the noise, so bring them in an order of their own.
class ViewMotionEstimator {
 public:
  using Options = ViewMotionOptions;

  explicit ViewMotionEstimator(const Options& options = Options()) : options_(options) {}

  /// From the pairs that may carry it (`seeds`). `last`: of the frame before, or of this one (`fresh`) over
  /// another gap: then fewer samples will do. What turns unlike `turn` needs up to twice the support.
  std::optional<ViewMotion> estimate(const std::vector<ViewPair>& pairs, const std::vector<int>& seeds,
                                     const ImageCells<double>& cells, double focal_px,
                                     const std::optional<ViewMotion>& last, bool fresh = false,
                                     const std::optional<ViewTurn>& turn = std::nullopt);
  /// Squared distance of a motion's turn from the prior's, in deviations of both.
  static double turn_distance2(const ViewTurn& turn, const ViewMotion& motion, double noise_px);

 private:
  static constexpr int kSample = 6, kScoredPerCell = 4, kLeastSamples = 10;
  static constexpr double kRest_px = 0.2;            ///< flow of a still image: noise of sub-pixel matching
  static constexpr double kLeastParallax_px = 0.02;  ///< where there is no noise to measure
  static constexpr double kConfidence = 0.99;        ///< probability that one sample was of inliers only
  static constexpr double kHopeless = 0.5;  ///< share of the support needed; the fit to all will not reach it
  static constexpr double kRounding = 1e-9;
  static constexpr std::uint64_t kSeed = 0x6d6f6e6f;

  void fill_cells(const std::vector<ViewPair>& pairs, const std::vector<int>& seeds,
                  const ImageCells<double>& cells);
  /// A cell with one point has half a vote: it may be an outlier.
  static double share(std::size_t points);

  ViewMotion refined(const ViewMotion& start, const std::vector<ViewPair>& pairs,
                     const std::vector<int>& which, const std::vector<double>& weights,
                     const ViewMotionFit::Options& options);

  /// Keeps the motion, with the sign of its direction, if it is supported better.
  void attempt(const std::vector<ViewPair>& pairs, ViewMotion motion);

  /// Factor of the support of a motion: 1 where it turns as the prior says, else down to kOtherTurn.
  double agreement(const ViewMotion& motion) const;
  static constexpr double kOtherTurn = 0.5;

  void try_sample(const std::vector<ViewPair>& pairs, const std::vector<int>& seeds, double focal_px,
                  const std::optional<ViewMotion>& last, int attempt_number);

  /// Forwards twice as often as to either side, up or down.
  ViewMotion start_motion(double focal_px);

  void polish(const std::vector<ViewPair>& pairs, const std::vector<int>& seeds);

  /// The flow of a plane has two explanations: direction and normal change places (Longuet-Higgins, "The
  /// visual ambiguity of a moving plane", 1984). One of them often puts a part of the plane behind the
  /// camera. Keeps the other one if it is supported better.
  void try_twin(const std::vector<ViewPair>& pairs, const std::vector<int>& seeds);

  /// Of the plane through the points that support best_, in steps of the camera: inverse_depth = normal .
  /// ray.
  std::optional<std::array<double, 3>> plane_normal(const std::vector<ViewPair>& pairs) const;

  ViewMotion without_needless_baseline(const std::vector<ViewPair>& pairs, const std::vector<int>& seeds,
                                       double focal_px);

  /// Nothing flows but what moves itself.
  bool is_still(const std::vector<ViewPair>& pairs) const;

  /// Share of what the rotation in best_ explains that flows as parallax does, by more than twice the noise.
  /// The noise is that of the distances to the epipolar lines and seldom flows so.
  double parallax_share(const std::vector<ViewPair>& pairs, const ViewMotion& with_baseline);

  Options options_;
  ViewMotionFit fit_;
  SampleGenerator rng_{kSeed};
  ViewMotion best_;
  double best_support_ = -1, votes_ = 0;
  std::optional<ViewTurn> turn_;
  CellLists in_cell_;  ///< seeds
  std::vector<int> occupied_, scored_, sample_, used_, inliers_;
  std::vector<double> weights_, score_weights_, distances_;
  std::vector<std::pair<double, double>> flows_;  ///< along, weight
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/motion/detail/view_motion_search-inl.hpp>
#endif
