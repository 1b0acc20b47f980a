// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/detection.hpp>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/core/span.hpp>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <optional>
#include <vector>

namespace dynfilter::testing {

/// Truth of a feature, as all figures of this project define it.
/// Dynamic: its point moved more than 10 mm over the last frames
/// and differs from its static prediction by more than 1 px.
/// Static: it did not move at all. DontCare: anything between.
enum class Truth : std::uint8_t { Static, Dynamic, DontCare };

/// One frame of an ExactScene. It owns the data of view() and must outlive the view.
struct ExactFrame {
  std::int64_t id = 0;
  double timestamp_s = 0;
  Camera camera;
  Pose T_world_camera;  ///< the true one
  PoseProvenance pose_provenance = PoseProvenance::None;

  std::vector<cv::KeyPoint> keypoints, keypoints_undistorted;
  std::vector<float> depth_m;     ///< empty for a mono and a stereo scene
  std::vector<float> right_u_px;  ///< of a stereo scene
  cv::Mat descriptors;
  std::int64_t reference_frame_id = -1;  ///< of the matches; -1: no matches
  std::vector<std::int32_t> reference_index;
  std::vector<std::int64_t> map_point_ids;
  std::vector<cv::Point3f> map_points_world_m;
  std::optional<std::vector<Detection>> detections;
  std::int64_t detections_frame_id = -1;

  // For the judge only, not part of the view:
  std::vector<int> point;  ///< point of the scene for each feature, the same in all frames
  std::vector<int> label;  ///< 0: static background, k: mover k (1, 2, ...), moving or not
  std::vector<Truth> truth;
  std::vector<std::uint8_t> mismatched;  ///< 1: its match is wrong

  std::size_t size() const { return keypoints.size(); }

  FrameView view() const;
};

}  // namespace dynfilter::testing

namespace dynfilter::testing {

inline FrameView ExactFrame::view() const {
  FrameView view;
  view.id = id;
  view.timestamp_s = timestamp_s;
  view.keypoints = keypoints;
  view.keypoints_undistorted = keypoints_undistorted;
  view.descriptors = descriptors;
  view.depth_m = depth_m;
  view.right_u_px = right_u_px;
  view.camera = camera;
  if (pose_provenance != PoseProvenance::None) view.T_world_camera = T_world_camera;
  view.pose_provenance = pose_provenance;
  view.map_point_ids = map_point_ids;
  view.map_points_world_m = map_points_world_m;
  if (reference_frame_id >= 0) view.matches = HostMatches{reference_frame_id, reference_index};
  if (detections) view.detections = DetectionInput{detections_frame_id, *detections};
  return view;
}

}  // namespace dynfilter::testing
