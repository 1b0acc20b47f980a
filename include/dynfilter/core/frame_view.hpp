// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstdint>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/core/span.hpp>
#include <opencv2/core.hpp>
#include <optional>
#include <string>

namespace dynfilter {

/// One detected object, in pixels of the distorted image.
struct Detection {
  cv::Rect2f box;          ///< x and y of the top left corner, width, height [px]
  int class_id = -1;       ///< class number of the detector; -1: unknown
  std::string class_name;  ///< e.g. "person"; filters select classes by name
  float score = 1.0F;      ///< confidence in [0, 1]
  int track_id = -1;       ///< -1: not tracked
  cv::Mat mask;            ///< CV_8UC1 instance mask of the whole image, 0: outside; empty: no mask
};

/// How a match's error is distributed: a patch with an edge but no corner slides along the edge. The
/// covariance of (u, v, depth) is, with the noise s [px] that the user of the match measures,
///   S = s^2 (across diag(1, 1, 0) + (along - across) v v^T),  v = (edge, depth_per_px).
/// Of a match of which nothing is known it is s^2 diag(1, 1, 0).
struct MatchSpread {
  cv::Point2f edge{1, 0};  ///< direction of the edge, of unit length
  float along = 1;         ///< variance along the edge, at least that across it
  float across = 1;        ///< variance across the edge
  float depth_per_px = 0;  ///< slope of the surface along the edge [m/px], 0 where it is not known

  static constexpr float kFar = 100;  ///< variance along the edge that is worth a note: ten deviations
  static constexpr float kSaysNothing = 1000;  ///< from which on a match tells nothing of the camera's motion
  static constexpr float kEdgeTurn_rad = 0.02F;   ///< error of the edge's direction
  bool slides() const { return along > across; }  ///< whether the error along the edge is larger
  /// Whether the numbers can be those of a match.
  bool valid() const { return across >= 1 && along >= across && std::isfinite(along + depth_per_px); }
  /// What a scalar weight may promise: the information in the worst direction.
  float reliability() const { return 1 / along; }
};

/// Matches that the host already has. Each current feature has the index of its match in the reference frame.
struct HostMatches {
  std::int64_t reference_frame_id = -1;
  Span<const std::int32_t> reference_index;  ///< one entry per feature; -1: no match
  Span<const MatchSpread> spread{};          ///< one entry per feature; empty: not known
};

/// Boxes of a detector. An empty list means that the detector found nothing.
/// Leave FrameView::detections unset if no result arrived.
struct DetectionInput {
  std::int64_t frame_id = -1;  ///< frame that the boxes were computed on; -1: this frame
  Span<const Detection> detections;
};

/// A semantic mask or label image of any size. It is scaled to the size of the frame.
struct MaskInput {
  std::int64_t frame_id = -1;  ///< frame that the mask was computed on; -1: this frame
  cv::Mat labels;              ///< CV_8UC1, 0 = background
};

/// A keyframe that shares map points with the current frame.
struct KeyframeView {
  std::int64_t id = -1;
  Pose T_world_camera;
  Span<const cv::KeyPoint> keypoints_undistorted;
  Span<const float> depth_m;
  Span<const std::int64_t> map_point_ids;
};

/// One frame of the host. Non-owning, cheap to fill and valid for one call. After the call the toolkit
/// neither reads nor refers to any memory of it: it deep-copies what it keeps. The exception is a depth image
/// with `depth_handed_over`. Only `keypoints` is required. A filter lists its other inputs (core/needs.hpp)
/// and abstains without them. Each per-feature array has one entry per keypoint or is empty.
struct FrameView {
  std::int64_t id = 0;  ///< increases from frame to frame
  double timestamp_s = 0;

  Span<const cv::KeyPoint> keypoints;              ///< distorted pixels, with octave
  Span<const cv::KeyPoint> keypoints_undistorted;  ///< undistorted pixels; empty: computed from `camera`
  cv::Mat descriptors;                             ///< one row per keypoint, CV_8U (binary)
  Span<const float> depth_m;  ///< depth along the optical axis; NaN, zero and negative: no depth

  /// Stereo: column of each feature's match in the right image [px], on the undistorted, rectified row.
  /// The disparity is the feature's undistorted column minus this one. NaN and negative: no match.
  /// Leave it empty for RGB-D, where a column would be computed from the depth.
  Span<const float> right_u_px;
  /// Stereo, rectified, as large as `grey`. Features without a column are searched in it, or count as hidden.
  cv::Mat right_grey;

  cv::Mat grey;             ///< CV_8UC1
  cv::Mat depth;            ///< CV_32FC1 or CV_16UC1, same size as `grey`; 0 and NaN: no depth
  double depth_unit_m = 1;  ///< metres per unit of `depth`: 1 for metres, 1/5000 for TUM's 16-bit images
  /// The host does not write to `depth` after the call, so no copy is made.
  /// Ignored for an image around a buffer of the host, which the host may free.
  bool depth_handed_over = false;

  std::optional<Camera> camera;
  Pose T_world_camera;
  PoseProvenance pose_provenance = PoseProvenance::None;  ///< None: T_world_camera is not set
  std::optional<MotionPrior> motion_prior;                ///< from sensors beside the camera

  Span<const std::int64_t> map_point_ids;        ///< one entry per feature; -1: no map point
  Span<const cv::Point3f> map_points_world_m;    ///< map point of each feature, in the world frame
  Span<const KeyframeView> covisible_keyframes;  ///< set at a keyframe only

  std::optional<HostMatches> matches;
  std::optional<DetectionInput> detections;
  std::optional<MaskInput> mask;

  std::size_t size() const { return keypoints.size(); }
};

}  // namespace dynfilter
