// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/error.hpp>
#include <filesystem>
#include <optional>
#include <string>

namespace dynfilter::io {

/// A camera as a file describes it.
/// The keys are those of ORB-SLAM settings (`Camera.fx`, in ORB-SLAM3 also `Camera1.fx`),
/// so such a file can be used directly.
struct CameraFile {
  Camera camera;
  std::optional<double> depth_units_per_m;  ///< `DepthMapFactor`
  std::optional<double> rate_hz;            ///< `Camera.fps`
  /// `Camera.sensor`: "rgbd", "stereo" or "mono", what an odometry uses unless told otherwise; "": not said.
  std::string sensor;
};

/// Reads `Camera.fx fy cx cy` [px].
/// Optional keys are `k1 k2 p1 p2 k3`, `bf` [px m], `width`, `height` [px], `fps`, `sensor` and `DepthMapFactor`.
/// Other keys are ignored. Throws IoError.
CameraFile read_camera(const std::filesystem::path& path);

}  // namespace dynfilter::io

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/config/detail/camera_file-inl.hpp>
#endif
