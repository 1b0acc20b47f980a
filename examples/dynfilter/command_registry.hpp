// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/registry.hpp>
#include <dynfilter/pipeline/pipeline.hpp>
#include <memory>
#include <string>
#include <vector>

#include "oracle_filter.hpp"

namespace dynfilter::command {

/// The filters that a pipeline may name here: built in, the oracle, and those of the plugins given.
Registry command_registry(const std::vector<std::string>& plugins,
                          std::shared_ptr<const OracleLabels> truth = std::make_shared<OracleLabels>());

/// A pipeline by a preset's name or by its file, made of these filters.
PipelineConfig load_pipeline(const std::string& name, const Registry& registry);

}  // namespace dynfilter::command
