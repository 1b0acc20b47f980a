// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/camera.hpp>

namespace dynfilter::render {

constexpr double kDepthUnitsPerM = 5000.0;  ///< of TUM's depth images

/// What the camera of a scene measures. In the office scenes it is TUM's freiburg3.
struct CameraModel {
  Camera camera = freiburg3_camera();
  double baseline_m = 0.11;  ///< to the right camera
  double rate_hz = 30;
  double depth_units_per_m = kDepthUnitsPerM;
  /// Of the depth images. 0: those of a structured-light camera. Otherwise exact up to this depth.
  double exact_depth_to_m = 0;
  bool is_stereo = false;  ///< an odometry uses the right image, not the depth image
};

/// KITTI's grey cameras, on the roof of a car.
inline CameraModel kitti_camera() {
  CameraModel model;
  model.camera = Camera();
  model.camera.fx_px = model.camera.fy_px = 718;
  model.camera.cx_px = 607, model.camera.cy_px = 185;
  model.camera.width_px = 1241, model.camera.height_px = 376;
  model.baseline_m = 0.54;
  model.rate_hz = 10;
  model.depth_units_per_m = 500;  // 16 bits reach 131 m
  model.exact_depth_to_m = 100;
  model.is_stereo = true;
  return model;
}

/// EuRoC's cameras on a flying robot, rectified.
inline CameraModel euroc_camera() {
  CameraModel model;
  model.camera = Camera();
  model.camera.fx_px = model.camera.fy_px = 435;
  model.camera.cx_px = 376, model.camera.cy_px = 240;
  model.camera.width_px = 752, model.camera.height_px = 480;
  model.baseline_m = 0.11;
  model.rate_hz = 20;
  model.depth_units_per_m = 2000;  // 16 bits reach 32 m
  model.exact_depth_to_m = 30;
  model.is_stereo = true;
  return model;
}

}  // namespace dynfilter::render
