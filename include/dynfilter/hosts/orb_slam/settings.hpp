// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/hosts/orb_slam/host_detector.hpp>
#include <dynfilter/hosts/orb_slam/params.hpp>
#include <dynfilter/core/error.hpp>
#include <dynfilter/config/registry.hpp>
#include <dynfilter/pipeline/builtin_filters.hpp>
#include <dynfilter/pipeline/pipeline.hpp>
#include <dynfilter/pipeline/presets.hpp>
#include <dynfilter/semantic/provider_registry.hpp>
#include <dynfilter/semantic/runner.hpp>
#include <memory>
#include <string>

namespace dynfilter {

struct OrbSlamSettings {
  OrbSlamParams params;
  PipelineConfig pipeline;
  std::string pipeline_file;                            ///< that it was read from; "" if made in code
  std::unique_ptr<SemanticRunner> semantics = nullptr;  ///< of `boxes`, `masks` or `detector`
};

/// The pipeline of the settings, taken out of them, as their parameters want it.
PipelineConfig configured_pipeline(OrbSlamSettings& settings);

namespace orb_slam::detail {

/// A file beside the settings file or by its path, or an installed pipeline, with `.yaml` or without.
std::string find_pipeline(const std::string& name, const std::string& settings_file, const std::string& path);

}  // namespace orb_slam::detail

/// Reads a host's own settings file: the `DynFilter.` keys, and the pipeline from its `pipeline` node, or
/// from the file or the installed pipeline that `DynFilter.pipeline` names, else the default.
/// Loads the plugins, and opens the file of boxes or starts the detector, that the keys name. Whatever else
/// the file holds is the host's, keys that repeat included; only keys that nearly are ours are errors. Throws
/// ConfigError.
OrbSlamSettings read_orb_slam_settings(const std::string& file, const Registry& registry = builtin_filters(),
                                       const ProviderRegistry& providers = {});

/// What the file says of `DynFilter.on_error`, whatever else is wrong with it. Never throws.
OnError read_on_error(const std::string& file) noexcept;

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/hosts/orb_slam/detail/settings-inl.hpp>
#endif
