// SPDX-License-Identifier: MIT
#include "command_registry.hpp"

#include <dynfilter/config/registry.hpp>
#include <dynfilter/core/error.hpp>
#include <dynfilter/detectors/dnn_provider.hpp>
#include <dynfilter/detectors/file_provider.hpp>
#include <dynfilter/detectors/process_provider.hpp>
#include <dynfilter/pipeline/builtin_filters.hpp>
#include <dynfilter/pipeline/pipeline.hpp>
#include <dynfilter/pipeline/pipeline_yaml.hpp>
#include <dynfilter/pipeline/presets.hpp>
#include <dynfilter/plugin/loader.hpp>
#include <dynfilter/semantic/detector_yaml.hpp>
#include <dynfilter/semantic/provider_registry.hpp>
#include <opencv2/core/utils/logger.hpp>
#include <utility>

#include "interruption.hpp"
#include "presets.hpp"
#include "text/option_hint.hpp"

namespace dynfilter::command {
namespace {

/// A signal also ends the wait for an answer of the program.
std::unique_ptr<SemanticProvider> process_provider(const YamlNode& node, const ProviderFiles&,
                                                   const std::vector<std::string>& other_keys) {
  return std::make_unique<ProcessProvider>(
      read_parameters<ProcessProviderParams>(node, ProcessProviderParams(), other_keys),
      [] { return Interruption::noted() != 0; });
}

}  // namespace

Registry command_registry(const std::vector<std::string>& plugins,
                          std::shared_ptr<const OracleLabels> truth) {
  Registry registry = builtin_filters();
  add_oracle(registry, std::move(truth));
  ProviderRegistry unused;
  for (const std::string& file : plugins) load_plugin(file, registry, unused);
  return registry;
}

ProviderRegistry command_providers(const std::vector<std::string>& plugins) {
  ProviderRegistry registry;
  registry.add<DnnProvider>();
  registry.add<FileProvider>();
  registry.add(
      {{ProcessProvider::kName, ProcessProvider::kSummary, describe_parameters<ProcessProviderParams>()},
       &process_provider});
  Registry unused;
  for (const std::string& file : plugins) load_plugin(file, unused, registry);
  return registry;
}

DetectorConfig load_detector(const std::string& name, const std::string& network_dir,
                             const std::vector<std::string>& plugins) {
  std::error_code error;
  if (!network_dir.empty() && !std::filesystem::is_directory(network_dir, error))
    throw IoError("--network-dir " + network_dir + ": no such folder of networks");
  // OpenCV would print its own errors about the network. They are returned as one line instead.
  cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
  DetectorConfig config =
      detector_from_file(find_preset(name, kDetectors), command_providers(plugins), network_dir);
  config.make = [make = config.make] {
    return with_hint<MissingFileError>("; --network-dir says where the detector's files are", make);
  };
  return config;
}

PipelineConfig named_pipeline(const std::string& name, const Registry& registry) {
  return load_pipeline(name, registry, command_folders(kPipelines));
}

}  // namespace dynfilter::command
