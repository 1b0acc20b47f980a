// SPDX-License-Identifier: MIT
#pragma once

#include <dlfcn.h>
#include <algorithm>
#include <array>
#include <cstddef>
#include <dynfilter/config/registry.hpp>
#include <dynfilter/core/error.hpp>
#include <dynfilter/plugin/abi.hpp>
#include <dynfilter/plugin/detail/module_file.hpp>
#include <dynfilter/semantic/provider_registry.hpp>
#include <filesystem>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

namespace dynfilter {

namespace detail {

/// Opens a module and never closes it.
/// Objects, code and type information of a plugin may be in use until the process ends.
inline void* open_module(const std::filesystem::path& file) {
  std::error_code failed;
  if (!std::filesystem::is_regular_file(file, failed))
    throw PluginError(file.string() + ": no such plugin file");
  if (const std::string fault = fault_of_module(file); !fault.empty())
    throw PluginError(file.string() + ": cannot be loaded: " + fault);
  // dlopen searches a bare name in the system folders, so the path is absolute.
  void* module =
      dlopen(std::filesystem::absolute(file).c_str(), RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);  // NOLINT
  if (module == nullptr) {
    const char* reason = dlerror();
    throw PluginError(file.string() +
                      ": cannot be loaded: " + (reason == nullptr ? "no reason given" : reason));
  }
  return module;
}

template <class Function>
Function function_of(void* module, const char* symbol, const std::filesystem::path& file) {
  void* address = dlsym(module, symbol);
  if (address == nullptr)
    throw PluginError(file.string() + ": not a dynfilter plugin: it has no function `" + symbol + "`");
  return reinterpret_cast<Function>(address);
}

inline void check_tag(const AbiTag* theirs, const std::filesystem::path& file) {
  static constexpr AbiTag ours = abi_tag();
  if (theirs == nullptr) throw PluginError(file.string() + ": its ABI tag is missing");
  if (const AbiField* field = first_difference(ours, *theirs))
    throw PluginError(file.string() + ": built for another " + field->name + ": it has " +
                      std::to_string(theirs->*field->value) + ", this program has " +
                      std::to_string(ours.*field->value) + "; build it again beside this program");
}

/// Collects what the module registers, so that a partial failure has no effect.
/// Empty if the module does not have the function.
template <class R>
R registered_by(void* module, const char* symbol, const std::filesystem::path& file) {
  R found;
  void* address = dlsym(module, symbol);
  if (address == nullptr) return found;
  const auto enter = reinterpret_cast<int (*)(R*, char*, std::size_t)>(address);
  std::array<char, 1024> error{};
  if (enter(&found, error.data(), error.size()) != 0)
    throw PluginError(file.string() + ": registration failed: " + error.data());
  return found;
}

/// Merges `known` and `found`. Throws PluginError if a name is taken.
template <class R>
R extended_by(const R& known, const R& found, const char* kind, const std::filesystem::path& file) {
  R extended = known;
  for (const std::string& name : found.names()) {
    if (known.find(name) != nullptr)
      throw PluginError(file.string() + ": a " + kind + " named `" + name + "` is registered already");
    extended.add(*found.find(name));
  }
  return extended;
}

inline void* open_plugin(const std::filesystem::path& file) {
  void* module = open_module(file);
  check_tag(function_of<PluginTagFunction>(module, kPluginTagSymbol, file)(), file);
  return module;
}

}  // namespace detail

/// Loads a plugin, adds its filters to `registry` and returns their names. Loading executes code of the file,
/// so load only files that you trust. The ABI tag is compared before any C++ function of the plugin is
/// called. The file is never unloaded. Throws PluginError with the file and the reason, and then does not
/// change `registry`. A truncated file is refused before it is loaded. Reasons: missing, not a library,
/// truncated, not a plugin, different ABI, registration failed, name taken.
inline std::vector<std::string> load_plugin(const std::filesystem::path& file, Registry& registry) {
  void* module = detail::open_plugin(file);
  detail::function_of<PluginRegisterFunction>(module, kPluginRegisterSymbol, file);
  const auto found = detail::registered_by<Registry>(module, kPluginRegisterSymbol, file);
  registry = detail::extended_by(registry, found, "filter", file);
  return found.names();
}

/// The same for plugins with filters, providers of boxes and masks, or both. Returns all names.
inline std::vector<std::string> load_plugin(const std::filesystem::path& file, Registry& registry,
                                            ProviderRegistry& providers) {
  void* module = detail::open_plugin(file);
  if (dlsym(module, kPluginProvidersSymbol) == nullptr)
    detail::function_of<PluginRegisterFunction>(module, kPluginRegisterSymbol, file);
  const auto filters = detail::registered_by<Registry>(module, kPluginRegisterSymbol, file);
  const auto found = detail::registered_by<ProviderRegistry>(module, kPluginProvidersSymbol, file);
  Registry extended = detail::extended_by(registry, filters, "filter", file);
  providers = detail::extended_by(providers, found, "provider", file);
  registry = std::move(extended);
  std::vector<std::string> names = filters.names();
  for (std::string& name : found.names()) names.push_back(std::move(name));
  return names;
}

/// Loads every *.so of a folder in name order, without subfolders. Returns the filters' names.
/// If one of them throws, `registry` does not change. Nothing else scans folders.
inline std::vector<std::string> load_plugin_directory(const std::filesystem::path& folder,
                                                      Registry& registry) {
  std::error_code failed;
  std::vector<std::filesystem::path> files;
  for (std::filesystem::directory_iterator entry(folder, failed), end; !failed && entry != end;
       entry.increment(failed))
    if (entry->path().extension() == ".so") files.push_back(entry->path());
  if (failed) throw PluginError(folder.string() + ": cannot be read: " + failed.message());
  std::sort(files.begin(), files.end());
  Registry extended = registry;
  std::vector<std::string> names;
  for (const std::filesystem::path& file : files)
    for (std::string& name : load_plugin(file, extended)) names.push_back(std::move(name));
  registry = std::move(extended);
  return names;
}

}  // namespace dynfilter
