// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/config/parameters.hpp>
#include <dynfilter/correspondence/correspondence_params.hpp>
#include <dynfilter/pipeline/pipeline.hpp>
#include <dynfilter/pipeline/pipeline_params.hpp>
#include <string>
#include <utility>
#include <vector>

namespace dynfilter::recorder {

/// Calls `use` with each parameter outside of the stages: its name, and the struct that has it.
template <class Config, class Use>
void for_each_parameter(Config& config, const Use& use) {
  const auto all = [&](const std::string& group, const auto& table, auto& params) {
    for (const auto& field : table.all()) use(group + field.name, field, &params);
  };
  all("", PipelineParams::fields(), config.params);
  all("correspondence.", CorrespondenceParams::fields(), config.correspondence);
  all("floor.", FloorParams::fields(), config.floor);
  all("initialisation.", InitialisationParams::fields(), config.initialisation);
}

inline std::vector<std::pair<std::string, std::string>> parameter_texts(const PipelineConfig& config) {
  std::vector<std::pair<std::string, std::string>> texts;
  for_each_parameter(config, [&](const std::string& name, const auto& field, const void* params) {
    texts.emplace_back(name, field.print(params));
  });
  return texts;
}

}  // namespace dynfilter::recorder
