// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/config/yaml.hpp>
#include <dynfilter/semantic/provider.hpp>
#include <dynfilter/semantic/provider_registry.hpp>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

namespace dynfilter {

/// A detector as described in YAML. Reading it opens no network; `make` does.
struct DetectorConfig {
  std::string name;  ///< value of `name:`, else the type
  std::string type;
  /// Opens the files and creates a new provider with every call.
  /// Throws ConfigError or IoError with one line that names the file and what was expected.
  std::function<std::unique_ptr<SemanticProvider>()> make;
};

/// Reads the map `detector:` of a document, which may contain other content.
/// Throws ConfigError with the source, the path, and the known keys or types.
DetectorConfig read_detector(const YamlDocument& document, const ProviderRegistry& registry,
                             ProviderFiles files);

/// Reads a detector's file. Files that it names are in `network_folder`, else beside it.
DetectorConfig detector_from_file(const std::filesystem::path& file, const ProviderRegistry& registry,
                                  const std::filesystem::path& network_folder = {});

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/semantic/detail/detector_yaml-inl.hpp>
#endif
