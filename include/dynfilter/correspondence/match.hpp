// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstdint>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/correspondence/correspondences.hpp>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

namespace dynfilter {

/// A frame that the toolkit keeps. It holds deep copies, because hosts reuse their buffers.
struct PastFrame {
  std::int64_t id = -1;
  double timestamp_s = 0;
  std::vector<cv::KeyPoint> keypoints;
  std::vector<float> depth_m;  ///< one per keypoint, or empty
  bool stereo = false;         ///< depth_m comes from the right image
  cv::Mat descriptors;
  cv::Mat depth;  ///< CV_32FC1 or CV_16UC1, or empty
  double depth_unit_m = 1;
  std::optional<Camera> camera;
  Pose T_world_camera;
  PoseProvenance pose_provenance = PoseProvenance::None;
};

/// The earlier frame that the current one is compared with.
struct Reference {
  bool keyframe = false;  ///< use the last keyframe
  int gap_frames = 1;     ///< otherwise this many frames back, or the oldest frame kept
};

/// Positions of the current features in a reference frame, with the depth there.
/// One entry per current feature. NaN if not found.
struct Match {
  bool valid = false;                    ///< belongs to the current frame (bookkeeping of FrameMatches)
  const PastFrame* reference = nullptr;  ///< null: there is no such frame
  Correspondences correspondences;
  std::vector<cv::Point2f> reference_undistorted_px;
  std::vector<float> reference_depth_m;
  std::vector<cv::Point3f> reference_points_m;  ///< in the frame of the reference camera

  /// Whether feature i has a match.
  bool found(std::size_t i) const { return correspondences.found[i] != 0; }
  /// Whether the match has depth in the reference frame.
  bool has_reference_point(std::size_t i) const { return std::isfinite(reference_points_m[i].z); }
};

}  // namespace dynfilter
