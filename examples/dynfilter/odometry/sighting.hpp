// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>

#include "frame_features.hpp"
#include "options.hpp"
#include "projection.hpp"

namespace dynfilter::odometry {

/// The measurement of a feature. Coarser octaves have more noise.
inline Sighting sighting(const OdometryOptions& options, const Pinhole& camera, const FrameFeatures& features,
                         std::size_t i) {
  const cv::KeyPoint& keypoint = features.keypoints_undistorted[i];
  const float depth_m = features.depth_m[i];
  const bool has_depth = depth_m > 0;
  Sighting s;
  s.measured_px = {keypoint.pt.x, keypoint.pt.y, has_depth ? camera.baseline_fx_px_m / depth_m : 0.0};
  s.pixel_weight = std::pow(options.extractor.scale_factor, -keypoint.octave);
  const MatchSpread& spread = features.spread[i];
  if (spread.slides())
    s.slide_px = std::sqrt(static_cast<double>(spread.along - spread.across)) / s.pixel_weight *
                 Eigen::Vector3d(spread.edge.x, spread.edge.y,
                                 has_depth ? -s.measured_px.z() / depth_m * spread.depth_per_px : 0.0);
  if (!has_depth) return s;
  // A projected pattern is measured at full size, a patch of the right image in the feature's octave.
  s.disparity_weight = options.sensor == Sensor::Stereo ? s.pixel_weight / options.stereo.disparity_sigma_px
                                                        : 1.0 / options.depth.disparity_sigma_px;
  return s;
}

}  // namespace dynfilter::odometry
