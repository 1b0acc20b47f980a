// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstdint>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/detection.hpp>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/core/span.hpp>
#include <opencv2/core.hpp>
#include <optional>

namespace dynfilter {

/// Matches that the host already has: for each current feature the index of its feature in the reference
/// frame.
struct HostMatches {
  std::int64_t reference_frame_id = -1;
  Span<const std::int32_t> reference_index;  ///< N entries, -1: no match
};

/// Boxes of a detector. An empty list means "the detector found nothing"; that none came is said by leaving
/// FrameView::detections unset.
struct DetectionInput {
  std::int64_t frame_id = -1;  ///< the frame they were computed on; detectors come late. -1: this frame
  Span<const Detection> detections;
};

/// A semantic mask or label image, of any size: it is scaled to the frame's.
struct MaskInput {
  std::int64_t frame_id = -1;  ///< the frame it was computed on. -1: this frame
  cv::Mat labels;              ///< CV_8UC1, 0 = background
};

/// What a host knows of a keyframe that sees the same map points as the current frame.
struct KeyframeView {
  std::int64_t id = -1;
  Pose T_world_camera;
  Span<const cv::KeyPoint> keypoints_undistorted;
  Span<const float> depth_m;
  Span<const std::int64_t> map_point_ids;
};

/// One frame as the host sees it. Non-owning, cheap to fill, valid for one call: the toolkit deep-copies what
/// it keeps, but for a depth image that was handed over. Only `keypoints` is required; a filter says what
/// else it needs (core/needs.hpp) and abstains without it. All per-feature arrays have one entry per keypoint
/// or are empty.
struct FrameView {
  std::int64_t id = 0;  ///< grows from frame to frame
  double timestamp_s = 0;

  Span<const cv::KeyPoint> keypoints;              ///< distorted pixels, with octave
  Span<const cv::KeyPoint> keypoints_undistorted;  ///< empty: computed from `camera`
  cv::Mat descriptors;                             ///< one row per keypoint, CV_8U (binary)
  Span<const float> depth_m;                       ///< along the optical axis; NaN, zero and negative: none

  cv::Mat grey;                    ///< CV_8UC1
  cv::Mat depth;                   ///< CV_32FC1 or CV_16UC1, same size as `grey`; 0 and NaN: none
  double depth_unit_m = 1;         ///< metres per unit of `depth`: 1 for metres, 1/5000 for TUM's uint16
  bool depth_handed_over = false;  ///< nobody writes into `depth` after the call: it is kept without a copy

  std::optional<Camera> camera;
  Pose T_world_camera;
  PoseProvenance pose_provenance = PoseProvenance::None;  ///< None: T_world_camera is not set

  Span<const std::int64_t> map_point_ids;        ///< -1: none
  Span<const cv::Point3f> map_points_world_m;    ///< entry i belongs to feature i
  Span<const KeyframeView> covisible_keyframes;  ///< at a keyframe

  std::optional<HostMatches> matches;
  std::optional<DetectionInput> detections;
  std::optional<MaskInput> mask;

  std::size_t size() const { return keypoints.size(); }
};

/// Nobody else refers to the image's memory, as far as cv::Mat knows: not the caller of whoever moved it
/// here, and no buffer that it was made around.
inline bool has_sole_owner(const cv::Mat& image) {
  return image.u != nullptr && image.u->refcount == 1;
}

/// NaN, zero, negative and infinite depths all mean "none".
inline bool valid_depth(float depth_m) {
  return depth_m > 0 && std::isfinite(depth_m);
}

}  // namespace dynfilter
