// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/filter.hpp>
#include <dynfilter/core/parameters.hpp>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace dynfilter {

/// Description of a filter, available without creating one.
/// `dynfilter filters` and the docs print it.
struct FilterCard {
  std::string name, summary;
  Needs needs;
  std::vector<FieldInfo> parameters;
};

using FilterFactory = std::function<std::unique_ptr<Filter>(const YamlNode& parameters)>;

/// The filters that a pipeline may name. A plain value that the caller passes in.
/// No filter registers itself, and nothing is global.
class Registry {
 public:
  struct Entry {
    FilterCard card;
    FilterFactory make;
  };

  /// Throws ConfigError if the name is taken.
  void add(Entry entry) {
    const std::string name = entry.card.name;
    if (name.empty()) throw ConfigError("", "a filter without a name cannot be registered");
    if (!entries_.emplace(name, std::move(entry)).second)
      throw ConfigError("", "a filter named `" + name + "` is registered already");
  }

  /// F has a struct F::Params with fields(), a constructor F(Params)
  /// and the constants F::kName and F::kSummary.
  template <class F>
  void add() {
    add({{F::kName, F::kSummary, F(typename F::Params()).needs(), describe_parameters<typename F::Params>()},
         [](const YamlNode& node) -> std::unique_ptr<Filter> {
           return std::make_unique<F>(read_parameters<typename F::Params>(node));
         }});
  }

  const Entry* find(const std::string& name) const {
    const auto it = entries_.find(name);
    return it == entries_.end() ? nullptr : &it->second;
  }
  std::vector<std::string> names() const {
    std::vector<std::string> result;
    for (const auto& [name, entry] : entries_) result.push_back(name);
    return result;
  }

 private:
  std::map<std::string, Entry> entries_;
};

}  // namespace dynfilter
