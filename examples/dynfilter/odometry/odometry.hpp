// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/pose.hpp>
#include <memory>
#include <opencv2/core/types.hpp>
#include <optional>
#include <vector>

#include "feature_judge.hpp"
#include "frame_features.hpp"
#include "io/sequence.hpp"
#include "io/trajectory.hpp"
#include "judge_gate.hpp"
#include "map.hpp"
#include "options.hpp"
#include "track_result.hpp"

namespace dynfilter::odometry {

/// Odometry like ORB-SLAM's tracking and local mapping, without loop closing.
/// For RGB-D, stereo and mono cameras: the sensor of the options.
/// The unit of a mono map is a third of the median depth of its first points.
/// It represents a user's SLAM. It knows about moving objects only through the judge.
/// Single-threaded and deterministic; for bit-exact results call cv::setNumThreads(1).
/// One object per camera stream.
class Odometry {
 public:
  /// `judge` may be null, which rejects nothing. It must outlive the odometry.
  Odometry(const Camera& camera, const OdometryOptions& options, FeatureJudge* judge);
  ~Odometry();
  Odometry(Odometry&&) noexcept;
  Odometry& operator=(Odometry&&) noexcept;

  /// Processes one frame.
  /// `frame.grey`: CV_8UC1.
  /// `frame.depth`: CV_16UC1 or CV_32FC1 in units of `depth_unit_m`, or empty. For RGB-D only.
  /// `frame.right`: CV_8UC1, rectified, or empty. For stereo only; the camera then has a baseline.
  /// `known` replaces the estimated pose, for example by that of another SLAM.
  /// Everything else runs as usual, including the judge.
  /// Provide a pose for every frame or for none.
  TrackResult process(const io::SequenceFrame& frame, const SemanticInputs& inputs = {},
                      const std::optional<Pose>& known = std::nullopt);

  /// Current poses of all tracked frames in the world of the first camera.
  /// Bundle adjustment of their keyframes is included. Provided poses do not change.
  std::vector<io::StampedPose> trajectory() const;

  /// Features of the last frame that no call rejected, with their map points.
  const FrameFeatures& features() const;

  /// Extracted features of the last frame, and the call point at which each one was rejected.
  const std::vector<cv::KeyPoint>& extracted() const;
  const std::vector<RejectedAt>& rejected_at() const;
  const Map& map() const;

 private:
  class Steps;
  std::unique_ptr<Steps> steps_;
};

}  // namespace dynfilter::odometry
