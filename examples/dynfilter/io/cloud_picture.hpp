// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/mapping/map_frame.hpp>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>

namespace dynfilter::mapping {

/// Renders a cloud from a camera, CV_8UC3 on dark grey.
/// Every point is a square with the projected size of `leaf_m`, and the nearest point wins.
/// Distortion is neglected.
cv::Mat render_cloud(const MapCloud& cloud, double leaf_m, const Camera& camera, cv::Size size,
                     const Pose& T_world_camera);

/// Rotates the camera about its centre until its y axis points straight down.
/// Floors, ceilings and desks concentrate the heights of a cloud at few values.
/// This concentration is strongest if the pose is level.
/// `T_world_camera` may be tilted by at most 44 degrees and must have little roll.
/// Cost: sorts the points.
Pose level_pose(const MapCloud& cloud, const Pose& T_world_camera);

/// The points at most `above_m` above a level pose: a room without its ceiling.
MapCloud without_ceiling(const MapCloud& cloud, const Pose& T_world_level, double above_m = 0.5);

/// An oblique view from behind and above a level pose.
/// It is as close as the middle 96 % of the cloud per axis allows.
Pose overview_pose(const MapCloud& cloud, const Pose& T_world_level, const Camera& camera, cv::Size size);

/// The room from above: its points without the ceiling, and where they are seen from.
struct Overview {
  MapCloud cloud;
  Pose T_world_camera;
};

/// `T_world_first`: some camera that saw the cloud, upright.
Overview overview_of(const MapCloud& cloud, const Camera& camera, cv::Size size, const Pose& T_world_first);

/// The picture of the overview.
cv::Mat render_overview(const MapCloud& cloud, double leaf_m, const Camera& camera, cv::Size size,
                        const Pose& T_world_first);

}  // namespace dynfilter::mapping
