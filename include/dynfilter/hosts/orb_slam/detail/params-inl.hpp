// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/hosts/orb_slam/params.hpp>

#include <dynfilter/core/inline.hpp>
#include <dynfilter/config/parameters.hpp>

namespace dynfilter {

DYNFILTER_INLINE HostSensor host_sensor(int sensor) {
  const int kind = sensor >= 0 ? sensor % 3 : 0;
  return kind == 0 ? HostSensor::Monocular : kind == 1 ? HostSensor::Stereo : HostSensor::RgbD;
}

DYNFILTER_INLINE const FieldTable<OrbSlamParams>& OrbSlamParams::fields() {
  using P = OrbSlamParams;
  static const FieldTable<P> table{
      flag("enabled", &P::enabled, "false: the host runs without dynfilter"),
      choice("on_error", &P::on_error, {{"stop", OnError::Stop}, {"off", OnError::Off}},
             "if the settings are wrong: end the host, or run it without rejection"),
      flag("keep_first_frame", &P::keep_first_frame,
           "false: reject features on boxes and masks in the first frame"),
      integer("min_features_before_map", &P::min_features_before_map, "features", {-1, 100000},
              "kept before the map exists; -1: 550, mono 250"),
      integer("min_features", &P::min_features, "features", {0, 100000}, "kept after that"),
      integer("covisible_keyframes", &P::covisible_keyframes, "keyframes", {0, 1000},
              "most keyframes that a new one is compared with"),
      words("plugins", &P::plugins, "modules to load, with filters and detectors"),
      text("boxes", &P::boxes, "file of boxes by timestamp"),
      text("masks", &P::masks, "folder of masks: PNG files named by their timestamps"),
      text("detector", &P::detector, "makes boxes or masks: a preset or a YAML file"),
      text("network_dir", &P::network_dir, "folder of the detector's network files"),
      text("detector_mode", &P::detector_mode,
           "async: in a thread; sync: the tracker waits; late:N, rate:HZ: tests"),
  };
  return table;
}

DYNFILTER_INLINE int OrbSlamParams::floor_before_map(HostSensor sensor) const {
  if (min_features_before_map >= 0) return min_features_before_map;
  return sensor == HostSensor::Monocular ? 250 : 550;
}

}  // namespace dynfilter
