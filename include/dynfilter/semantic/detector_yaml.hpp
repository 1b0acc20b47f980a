// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/config/near_miss.hpp>
#include <dynfilter/config/parameters.hpp>
#include <dynfilter/config/yaml.hpp>
#include <dynfilter/core/error.hpp>
#include <dynfilter/semantic/box_masks.hpp>
#include <dynfilter/semantic/provider.hpp>
#include <dynfilter/semantic/provider_registry.hpp>
#include <exception>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace dynfilter {

/// A detector as described in YAML. Reading it opens no network; `make` does.
struct DetectorConfig {
  std::string name;  ///< value of `name:`, else the type
  std::string type;
  /// Opens the files and creates a new provider with every call.
  /// Throws ConfigError or IoError with one line that names the file and what was expected.
  std::function<std::unique_ptr<SemanticProvider>()> make;
};

namespace detail {

/// The keys under `detector:` that do not belong to the provider.
inline const std::vector<std::string>& detector_keys() {
  static const std::vector<std::string> keys{"name", "about", "type", "box_masks"};
  return keys;
}

inline const ProviderRegistry::Entry& provider_entry(const YamlNode& node, const ProviderRegistry& registry) {
  const std::vector<std::string> known = registry.names();
  const auto type = node.find("type");
  if (!type) node.fail("expected the key `type`, one of " + joined(known));
  const ProviderRegistry::Entry* entry = registry.find(type->text());
  if (entry == nullptr) type->fail(expected_one_of(known, type->text()));
  return *entry;
}

/// Adds the name of the YAML file to every error, except to errors that name a file.
template <class F>
auto in_document(const std::string& source, const F& f) {
  try {
    return f();
  } catch (const ConfigError& error) {
    if (source.empty()) throw;
    throw ConfigError(source, error.what());
  } catch (const Error&) {
    throw;
  } catch (const std::exception& error) {
    throw ConfigError(source, std::string("the provider cannot be made: ") + error.what());
  }
}

}  // namespace detail

/// Reads the map `detector:` of a document, which may contain other content.
/// Throws ConfigError with the source, the path, and the known keys or types.
inline DetectorConfig read_detector(const YamlDocument& document, const ProviderRegistry& registry,
                                    ProviderFiles files) {
  return detail::in_document(document.source(), [&] {
    const auto node = document.root().find("detector");
    if (!node) throw ConfigError("", "expected the key `detector`");
    const ProviderRegistry::Entry entry = detail::provider_entry(*node, registry);
    DetectorConfig config;
    config.type = config.name = entry.card.type;
    if (const auto name = node->find("name")) config.name = name->text();
    if (const auto about = node->find("about")) about->text();
    std::optional<BoxMaskParams> box_masks;
    if (const auto wanted = node->find("box_masks")) box_masks = read_parameters<BoxMaskParams>(*wanted);
    // Captures the document, because nodes are valid only while it exists.
    config.make = [document, node = *node, entry, files = std::move(files), box_masks] {
      return detail::in_document(document.source(), [&]() -> std::unique_ptr<SemanticProvider> {
        auto provider = entry.make(node, files, detail::detector_keys());
        if (!box_masks) return provider;
        return std::make_unique<BoxMaskProvider>(std::move(provider), *box_masks);
      });
    };
    return config;
  });
}

/// Reads a detector's file. Files that it names are in `network_folder`, else beside it.
inline DetectorConfig detector_from_file(const std::filesystem::path& file, const ProviderRegistry& registry,
                                         const std::filesystem::path& network_folder = {}) {
  ProviderFiles files;
  if (!network_folder.empty()) files.folders.push_back(network_folder);
  files.folders.push_back(file.has_parent_path() ? file.parent_path() : std::filesystem::path("."));
  return read_detector(YamlDocument::from_file(file.string()), registry, std::move(files));
}

}  // namespace dynfilter
