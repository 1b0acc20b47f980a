// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/config/parameters.hpp>
#include <dynfilter/semantic/provider.hpp>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace dynfilter {

/// A file that a detector's YAML names is not there.
class MissingFileError : public IoError {
 public:
  using IoError::IoError;
};

/// Where the files lie that a detector's YAML names: folders in the order in which they are searched.
struct ProviderFiles {
  std::vector<std::filesystem::path> folders;

  /// Finds a file or folder by its name in the YAML. An absolute path is used directly.
  /// Throws IoError with the searched folders and the purpose `what`.
  std::filesystem::path find(const std::string& name, const std::string& what) const {
    std::error_code failed;
    std::filesystem::path path(name);
    if (path.is_absolute() || folders.empty()) {
      if (!name.empty() && std::filesystem::exists(path, failed)) return path;
      throw MissingFileError(name + ": no such file (expected " + what + ")");
    }
    std::string looked, last;
    for (const std::filesystem::path& folder : folders) {
      if (!name.empty() && std::filesystem::exists(folder / path, failed)) return folder / path;
      const auto real = std::filesystem::weakly_canonical(std::filesystem::absolute(folder, failed), failed);
      if (real != last) looked += (looked.empty() ? "" : " nor in ") + real.string();
      last = real.string();
    }
    throw MissingFileError(name + ": no such file in " + looked + " (expected " + what + ")");
  }
};

/// Description of a kind of provider, available without creating one.
struct ProviderCard {
  std::string type, summary;
  std::vector<FieldInfo> parameters;
};

/// Creates a provider from the map under `detector:`.
/// Keys in `other_keys` are accepted but do not belong to the provider.
using ProviderFactory = std::function<std::unique_ptr<SemanticProvider>(
    const YamlNode& node, const ProviderFiles& files, const std::vector<std::string>& other_keys)>;

/// The kinds of provider that a detector's YAML may name as its `type`.
/// A plain value that the caller passes in. Nothing registers itself, and nothing is global.
class ProviderRegistry {
 public:
  /// A provider's card, and what makes one.
  struct Entry {
    ProviderCard card;
    ProviderFactory make;
  };

  /// Throws ConfigError if the name is taken.
  void add(Entry entry) {
    const std::string type = entry.card.type;
    if (type.empty()) throw ConfigError("", "a provider needs a name to be registered");
    if (!entries_.emplace(type, std::move(entry)).second)
      throw ConfigError("", "a provider named `" + type + "` is registered already");
  }

  /// P has a struct P::Params with fields(), and the constants P::kName and P::kSummary.
  /// Its constructor is P(Params, ProviderFiles), or P(Params) if it opens no files.
  /// The constructor throws IoError for files and ConfigError for inconsistent parameters.
  template <class P>
  void add() {
    using Params = typename P::Params;
    add({{P::kName, P::kSummary, describe_parameters<Params>()},
         [](const YamlNode& node, const ProviderFiles& files,
            const std::vector<std::string>& other_keys) -> std::unique_ptr<SemanticProvider> {
           Params params = read_parameters<Params>(node, Params(), other_keys);
           if constexpr (std::is_constructible_v<P, Params, const ProviderFiles&>)
             return std::make_unique<P>(std::move(params), files);
           else
             return std::make_unique<P>(std::move(params));
         }});
  }

  const Entry* find(const std::string& type) const {
    const auto it = entries_.find(type);
    return it == entries_.end() ? nullptr : &it->second;
  }
  std::vector<std::string> names() const {
    std::vector<std::string> result;
    for (const auto& [type, entry] : entries_) result.push_back(type);
    return result;
  }

 private:
  std::map<std::string, Entry> entries_;
};

}  // namespace dynfilter
