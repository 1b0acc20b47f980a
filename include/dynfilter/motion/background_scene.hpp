// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/core/span.hpp>
#include <dynfilter/geometry/depth_noise.hpp>
#include <dynfilter/geometry/rigid_motion.hpp>
#include <opencv2/core/types.hpp>
#include <optional>

namespace dynfilter {

/// What a background motion is estimated from. One entry per feature in every span but `seeds`.
struct RigidBackgroundScene {
  static constexpr float kMobile = 0.5F;  ///< mobility from which on a point counts as having moved

  Camera camera;
  Span<const cv::Point3f> reference_m, current_m;  ///< in the camera frames; z not finite: no point
  Span<const cv::Point2f> pixels;                  ///< current positions of the features
  Span<const float> static_belief;                 ///< weight in the choice, [0, 1]
  Span<const float> mobility;                      ///< [0, 1] moved recently; empty: none did
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

/// One rigid motion that some of the points follow.
struct MotionProposal {
  /// Where the proposal comes from.
  enum class From { Expected, Predicted, Support };
  From from = From::Support;
  RigidMotion motion;
  double area = 0;     ///< share of the visible surface that it explains best
  double order = 0.5;  ///< share of the neighbouring points of other motions that are nearer
  double score = 0;    ///< log-probability of being the background, up to a constant
};

}  // namespace dynfilter
