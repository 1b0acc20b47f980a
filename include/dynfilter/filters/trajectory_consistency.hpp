// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <dynfilter/config/registry.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/evidence/camera_motion.hpp>
#include <dynfilter/evidence/evidence.hpp>
#include <dynfilter/geometry/neighbour_noise.hpp>
#include <dynfilter/geometry/rigid_misses.hpp>
#include <dynfilter/geometry/rigid_motion.hpp>
#include <opencv2/core/types.hpp>
#include <optional>
#include <vector>

namespace dynfilter {

/// What is compared with the camera motion.
enum class TrajectoryMode {
  Rigid,        ///< the full motion predicts the position of a static point
  Displacement  ///< as published: compares the distances moved by the point and by the camera
};
/// Form of the threshold.
enum class TrajectoryThreshold {
  Noise,  ///< chi-square under the noise model of the depth camera
  Metric  ///< alpha + beta * depth, in metres (RTS-SLAM eq. 13)
};
struct TrajectoryConsistencyParams {
  TrajectoryMode mode = TrajectoryMode::Rigid;
  TrajectoryThreshold threshold = TrajectoryThreshold::Noise;
  /// Threshold noise: largest chi-square of a static feature, 3 degrees of freedom.
  static constexpr double kMaxChi2 = 16.0;
  double pixel_sigma_px = 0.6;
  /// Threshold noise: factor on the standard deviation of the depth noise model.
  static constexpr double kDepthSigmaFactor = 2.0;
  bool measured_noise = false;
  double alpha_m = 0.015;
  double beta = 0.003;
  double max_displacement_m = 0;
  static constexpr double kMaxDepth_m = 6.0;  ///< Largest depth of a feature that is judged.
  int gap_frames = 1;
  MotionSource motion = MotionSource::Seeds;

  static const FieldTable<TrajectoryConsistencyParams>& fields();
};

/// Rejects features whose 3-D motion differs from the camera's (RTS-SLAM sec. 3.4).
///
/// Formula:  Mode displacement (eq. 10-14): | |P_t - P_r| - |t| | > alpha + beta min(d_t, d_r). This form
///           neglects rotation. Mode rigid: |R P_r + t - P_t| against the same threshold. Threshold noise
///           replaces this by chi-square > max_chi2 of the residual (u, v, depth), under flow noise, depth
///           noise and the uncertainty of the motion. With measured_noise, the first two are at least those
///           of this frame's seeds (geometry/neighbour_noise.hpp, geometry/rigid_misses.hpp), and the motion
///           is refitted under them. Mode rigid also limits |R P_r + t - P_t| to max_displacement_m (Zhou et
///           al. eq. 1-2).
/// Needs:    depth, camera, correspondences. Optional: the host's poses.
/// Abstains: without depth or correspondence, beyond 6 m, and without a camera motion.
/// Blind to: motion below the depth camera's noise over the gap;
///           everything if the motion was fitted on movers.
/// State:    none; the pipeline keeps gap_frames frames.
/// Cost:     about 0.1 ms for 1000 features, with motion, without flow; measured_noise adds 0.3 ms.
class TrajectoryConsistencyFilter final
    : public ParametricFilter<TrajectoryConsistencyFilter, TrajectoryConsistencyParams> {
 public:
  using ParametricFilter::ParametricFilter;
  static constexpr const char* kName = "trajectory_consistency";
  static constexpr const char* kSummary = "features whose 3-D motion differs from the camera's";

  Needs needs() const override {
    return {Input::Depth | Input::Camera | Input::Correspondence, Input::Pose, params_.gap_frames};
  }

  void apply(const Evidence& evidence, Votes& votes) override;

 private:
  bool judgeable(const Evidence& evidence, const Match& match, std::size_t i) const;

  double limit_m(const Match& match, const cv::Point3f& now, std::size_t i) const {
    return params_.alpha_m + params_.beta * static_cast<double>(std::min(match.reference_depth_m[i], now.z));
  }

  void judge_displacement(const Evidence& evidence, const Match& match, const RigidMotion& motion,
                          Votes& votes) const;

  void judge_rigid(const Evidence& evidence, const Match& match, const RigidMotion& motion, Votes& votes);

  /// Standard deviations: of a correspondence, and of a depth in units of the sensor's model.
  struct Noise {
    double pixel_px, depth_factor;
  };

  void judge_noise(const Evidence& evidence, const Match& match, const RigidMotion& motion,
                   const Noise& sigma, Votes& votes) const;

  /// Noise and motion depend on each other: a fit under too little noise follows the errors of the depths.
  void judge_measured(const Evidence& evidence, const Match& match, RigidMotion motion, Votes& votes);
  /// The features that the motion was fitted on, with depth in both frames.
  void collect_measured(const Evidence& evidence, const Match& match, const RigidMotion& motion);
  std::optional<Noise> measure(const Evidence& evidence, const Match& match, const RigidMotion& motion);
  void fit_under(const Noise& noise, const Evidence& evidence, const Match& match, RigidMotion& motion);

  void judge_metric(const Evidence& evidence, const Match& match, const RigidMotion& motion,
                    Votes& votes) const;

  /// d_D = |R P_r + t - P_t|.
  static double displacement_m(const RigidMotion& motion, const Match& match, const Evidence& evidence,
                               std::size_t i);
  /// True if the displacement is within the range of an object.
  bool possible(double moved_m) const {
    return params_.max_displacement_m <= 0 || moved_m <= params_.max_displacement_m;
  }

  static void cast(Votes& votes, std::size_t i, double distance, double limit) {
    votes.cast(i, distance > limit ? Vote::Dynamic : Vote::Static, suspicion(distance, limit));
  }

  static constexpr float kNeighbours_px = 30;  ///< Whose misses are compared.
  static constexpr int kRefits = 2;            ///< on TUM frames a third changes next to nothing

  std::vector<int> seeds_;
  RigidMisses misses_;
  NeighbourNoise neighbour_noise_;
  RigidMotionEstimator refit_;
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/filters/detail/trajectory_consistency-inl.hpp>
#endif
