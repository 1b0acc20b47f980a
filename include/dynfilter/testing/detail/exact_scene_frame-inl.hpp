// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/testing/exact_scene_frame.hpp>

#include <dynfilter/core/inline.hpp>
#include <dynfilter/core/span.hpp>

namespace dynfilter::testing {

DYNFILTER_INLINE FrameView ExactFrame::view() const {
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
