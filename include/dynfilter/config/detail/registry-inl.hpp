// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/config/registry.hpp>

#include <dynfilter/core/inline.hpp>
#include <utility>

namespace dynfilter {

DYNFILTER_INLINE void Registry::add(Entry entry) {
  const std::string name = entry.card.name;
  if (name.empty()) throw ConfigError("", "a filter without a name cannot be registered");
  if (!entries_.emplace(name, std::move(entry)).second)
    throw ConfigError("", "a filter named `" + name + "` is registered already");
}

DYNFILTER_INLINE const Registry::Entry* Registry::find(const std::string& name) const {
  const auto it = entries_.find(name);
  return it == entries_.end() ? nullptr : &it->second;
}

DYNFILTER_INLINE std::vector<std::string> Registry::names() const {
  std::vector<std::string> result;
  for (const auto& [name, entry] : entries_) result.push_back(name);
  return result;
}

}  // namespace dynfilter
