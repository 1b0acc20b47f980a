// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/config/field_table.hpp>
#include <dynfilter/pipeline/builtin_filters.hpp>
#include <dynfilter/pipeline/presets.hpp>
#include <dynfilter/semantic/provider_registry.hpp>
#include <dynfilter/semantic/runner.hpp>

namespace dynfilter {

/// What a frame has besides one image.
enum class HostSensor { Monocular, Stereo, RgbD };

/// System::eSensor of both versions as a number: 0 one camera, 1 two, 2 RGB-D; 3 to 5 the same with inertia.
HostSensor host_sensor(int sensor);

/// What happens when the settings cannot be used (OrbSlam::start).
enum class OnError {
  Stop,  ///< the host gets no OrbSlam, and ends
  Off    ///< the host runs as if nothing had been added
};

/// How a verdict is handed to an ORB-SLAM host, and where boxes and masks come from. In its settings file
/// `enabled` is `DynFilter.enabled`, and so on.
struct OrbSlamParams {
  bool enabled = true;
  OnError on_error = OnError::Stop;
  bool keep_first_frame = false;
  int min_features_before_map = -1;
  int min_features = 100;
  /// Most keyframes that a new one is compared with: as many as share most of its points.
  static constexpr int kCovisibleKeyframes = 5;
  std::vector<std::string> plugins;
  std::string boxes, masks;
  std::string detector;
  std::string network_dir;
  std::string detector_mode = "async";
  std::string record;

  static const FieldTable<OrbSlamParams>& fields();

  /// Smallest number of features before there is a map; -1 there: by sensor.
  int floor_before_map(HostSensor sensor) const;
};

/// What a host's settings file says of dynfilter.
struct OrbSlamSettings {
  OrbSlamParams params;
  PipelineConfig pipeline;
  std::string pipeline_file;                            ///< that it was read from; "" if made in code
  std::unique_ptr<SemanticRunner> semantics = nullptr;  ///< of `boxes`, `masks` or `detector`
};

/// The pipeline of the settings, taken out of them, as their parameters want it.
PipelineConfig configured_pipeline(OrbSlamSettings& settings);
/// Starts the flight recorder that `record` names. Throws ConfigError if its file cannot be written.
void start_recording(const OrbSlamParams& params, Pipeline& pipeline);

/// Reads the keys `DynFilter.NAME` of a host's own settings file. The pipeline is the file's `pipeline` node,
/// or the file or installed pipeline that `DynFilter.pipeline` names, or the default. Loads the plugins, and
/// opens the file of boxes or starts the detector, that the keys name. Whatever else the file holds is the
/// host's, keys that repeat included; only keys that nearly are ours are errors. Throws ConfigError.
OrbSlamSettings read_orb_slam_settings(const std::string& file, const Registry& registry = builtin_filters(),
                                       const ProviderRegistry& providers = {});

/// What the file says of `DynFilter.on_error`, whatever else is wrong with it. Never throws.
OnError read_on_error(const std::string& file) noexcept;

/// What boxes and masks the settings promise, before any came. Of a detector both: which of them it makes is
/// seen later.
Input semantic_inputs(const OrbSlamParams& params);

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/hosts/orb_slam/detail/settings-inl.hpp>
#endif
