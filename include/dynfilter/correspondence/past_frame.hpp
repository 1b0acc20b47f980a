// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/pose.hpp>
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
  bool stereo = false;         ///< depth_m comes from the columns in the right image
  cv::Mat descriptors;
  cv::Mat depth;  ///< CV_32FC1 or CV_16UC1, or empty
  double depth_unit_m = 1;
  std::optional<Camera> camera;
  Pose T_world_camera;
  PoseProvenance pose_provenance = PoseProvenance::None;
};

}  // namespace dynfilter
