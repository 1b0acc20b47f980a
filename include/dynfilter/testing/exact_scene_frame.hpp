// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <dynfilter/core/frame_view.hpp>
#include <limits>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

namespace dynfilter::testing {

/// Direction of an undistorted pixel in the camera's frame, with z = 1.
inline Eigen::Vector3d ray(const Camera& camera, const cv::Point2d& px) {
  return {(px.x - camera.cx_px) / camera.fx_px, (px.y - camera.cy_px) / camera.fy_px, 1};
}

/// True if the pixel is between the outermost pixel centres of the image. False for NaN.
inline bool in_image(const Camera& camera, const cv::Point2d& px) {
  return px.x >= 0 && px.y >= 0 && px.x <= camera.width_px - 1 && px.y <= camera.height_px - 1;
}

/// Undistorted pixel of a point in the camera's frame; NaN behind it.
inline cv::Point2d project(const Camera& camera, const Eigen::Vector3d& point_m) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  if (!(point_m.z() > 1e-6)) return {kNan, kNan};
  return {camera.fx_px * point_m.x() / point_m.z() + camera.cx_px,
          camera.fy_px * point_m.y() / point_m.z() + camera.cy_px};
}

/// Distorted pixel of an undistorted one (OpenCV's radial-tangential model).
inline cv::Point2d distort(const Camera& camera, const cv::Point2d& px) {
  const auto& [k1, k2, p1, p2, k3] = camera.distortion;
  const double x = (px.x - camera.cx_px) / camera.fx_px, y = (px.y - camera.cy_px) / camera.fy_px;
  const double r2 = x * x + y * y, radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3));
  return {camera.fx_px * (x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)) + camera.cx_px,
          camera.fy_px * (y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y) + camera.cy_px};
}

/// Truth of a feature, as all figures of this project define it. Dynamic: its point moved more than 10 mm
/// over the last frames and differs from its static prediction by more than 1 px. Static: it did not move at
/// all. DontCare: anything between.
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
  std::vector<MatchSpread> spread;  ///< of the matches; empty: not known
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

  FrameView view() const;  ///< valid while this frame exists
};

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
  if (reference_frame_id >= 0) view.matches = HostMatches{reference_frame_id, reference_index, spread};
  if (detections) view.detections = DetectionInput{detections_frame_id, *detections};
  return view;
}

}  // namespace dynfilter::testing
