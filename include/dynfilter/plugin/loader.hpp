// SPDX-License-Identifier: MIT
#pragma once

#include <dlfcn.h>
#include <dynfilter/core/error.hpp>
#include <dynfilter/config/registry.hpp>
#include <dynfilter/semantic/provider_registry.hpp>
#include <filesystem>
#include <string>
#include <vector>

namespace dynfilter {

/// Loads a plugin, adds its filters to `registry` and returns their names.
/// Loading executes code of the file, so load only files that you trust.
/// The ABI tag is compared before any C++ function of the plugin is called.
/// The file is never unloaded.
/// Throws PluginError with the file and the reason, and then does not change `registry`.
/// A truncated file is refused before it is loaded.
/// Reasons: missing, not a library, truncated, not a plugin, different ABI, registration failed, name taken.
std::vector<std::string> load_plugin(const std::filesystem::path& file, Registry& registry);

/// The same for plugins with filters, providers of boxes and masks, or both. Returns all names.
std::vector<std::string> load_plugin(const std::filesystem::path& file, Registry& registry,
                                     ProviderRegistry& providers);

/// Loads every *.so of a folder in name order, without subfolders. Returns the filters' names.
/// If one of them throws, `registry` does not change. Nothing else scans folders.
std::vector<std::string> load_plugin_directory(const std::filesystem::path& folder, Registry& registry);

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/plugin/detail/loader-inl.hpp>
#endif
