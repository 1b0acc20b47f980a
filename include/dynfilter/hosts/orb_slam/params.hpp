// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/config/field_table.hpp>
#include <string>
#include <vector>

namespace dynfilter {

enum class HostSensor { Monocular, Stereo, RgbD };

/// System::eSensor of both versions as a number: 0 one camera, 1 two, 2 RGB-D; 3 to 5 the same with inertia.
HostSensor host_sensor(int sensor);

/// How a verdict is handed to an ORB-SLAM host. In its settings file each has `DynFilter.` before it.
/// What happens when the settings cannot be used (OrbSlam::start).
enum class OnError {
  Stop,  ///< the host gets no OrbSlam, and ends
  Off    ///< the host runs as if nothing had been added
};

/// How a verdict is handed to an ORB-SLAM host, and where boxes and masks come from. In its settings file
/// each has `DynFilter.` before it.
struct OrbSlamParams {
  bool enabled = true;
  OnError on_error = OnError::Stop;
  bool keep_first_frame = true;
  int min_features_before_map = -1;
  int min_features = 100;
  int covisible_keyframes = 5;
  std::vector<std::string> plugins;
  std::string boxes, masks;
  std::string detector;
  std::string network_dir;
  std::string detector_mode = "async";

  static const FieldTable<OrbSlamParams>& fields();

  int floor_before_map(HostSensor sensor) const;
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/hosts/orb_slam/detail/params-inl.hpp>
#endif
