// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/config/registry.hpp>
#include <dynfilter/pipeline/pipeline.hpp>
#include <dynfilter/semantic/detector_yaml.hpp>
#include <dynfilter/semantic/provider_registry.hpp>
#include <memory>
#include <string>
#include <vector>

#include "oracle_filter.hpp"

namespace dynfilter::command {

/// The filters that a pipeline may name here: built-in ones, the oracle, and those of `plugins`.
Registry command_registry(const std::vector<std::string>& plugins,
                          std::shared_ptr<const OracleLabels> truth = std::make_shared<OracleLabels>());

/// The kinds of provider that a detector's file may name here:
/// built-in ones and those of `plugins`.
ProviderRegistry command_providers(const std::vector<std::string>& plugins);

/// Loads a detector by preset name or file.
/// Files that it names are in `network_dir`, else beside the detector's file.
DetectorConfig load_detector(const std::string& name, const std::string& network_dir,
                             const std::vector<std::string>& plugins);

/// Loads a pipeline by preset name or file, made of these filters.
PipelineConfig named_pipeline(const std::string& name, const Registry& registry);

}  // namespace dynfilter::command
