// SPDX-License-Identifier: MIT
#include "command_registry.hpp"

#include <dynfilter/filters/builtin.hpp>
#include <dynfilter/pipeline/yaml.hpp>
#include <dynfilter/plugin/loader.hpp>
#include <utility>

#include "presets.hpp"

namespace dynfilter::command {

Registry command_registry(const std::vector<std::string>& plugins,
                          std::shared_ptr<const OracleLabels> truth) {
  Registry registry = builtin_filters();
  add_oracle(registry, std::move(truth));
  for (const std::string& file : plugins) load_plugin(file, registry);
  return registry;
}

PipelineConfig load_pipeline(const std::string& name, const Registry& registry) {
  return pipeline_from_file(find_pipeline(name).string(), registry);
}

}  // namespace dynfilter::command
