// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <dynfilter/config/registry.hpp>
#include <dynfilter/plugin/abi.hpp>
#include <dynfilter/semantic/provider_registry.hpp>
#include <exception>

namespace dynfilter::detail {

inline void copy_message(const char* text, char* out, std::size_t out_bytes) noexcept {
  if (out == nullptr || out_bytes == 0) return;
  std::strncpy(out, text, out_bytes - 1);
  out[out_bytes - 1] = '\0';
}

/// No exception leaves a plugin. Errors are returned as text.
template <class... Added, class R>
int register_in(R* registry, char* error, std::size_t error_bytes) noexcept {
  try {
    (registry->template add<Added>(), ...);
    return 0;
  } catch (const std::exception& e) {
    copy_message(e.what(), error, error_bytes);
  } catch (...) {
    copy_message("something that is no std::exception was thrown", error, error_bytes);
  }
  return 1;
}

}  // namespace dynfilter::detail

/// A plugin has its tag and at least one of these two functions. plugin/export.hpp generates them.
#define DYNFILTER_REGISTER_FILTERS(...)                                               \
  extern "C" __attribute__((visibility("default"))) int dynfilter_plugin_register(    \
      dynfilter::Registry* registry, char* error, std::size_t error_bytes) noexcept { \
    return dynfilter::detail::register_in<__VA_ARGS__>(registry, error, error_bytes); \
  }                                                                                   \
  static_assert(true, "takes the semicolon")
#define DYNFILTER_REGISTER_PROVIDERS(...)                                                     \
  extern "C" __attribute__((visibility("default"))) int dynfilter_plugin_register_providers(  \
      dynfilter::ProviderRegistry* registry, char* error, std::size_t error_bytes) noexcept { \
    return dynfilter::detail::register_in<__VA_ARGS__>(registry, error, error_bytes);         \
  }                                                                                           \
  static_assert(true, "takes the semicolon")

/// The function that every plugin has.
#define DYNFILTER_PLUGIN_TAG()                                               \
  extern "C" __attribute__((visibility("default"))) const dynfilter::AbiTag* \
  dynfilter_plugin_tag() noexcept {                                          \
    static constexpr dynfilter::AbiTag tag = dynfilter::abi_tag();           \
    return &tag;                                                             \
  }                                                                          \
  static_assert(true, "takes the semicolon")

/// Exports filters from a loadable module. Write this line in one source file, outside all namespaces:
///     DYNFILTER_EXPORT_FILTERS(mine::MyFilter, mine::OtherFilter);
#define DYNFILTER_EXPORT_FILTERS(...) \
  DYNFILTER_PLUGIN_TAG();             \
  DYNFILTER_REGISTER_FILTERS(__VA_ARGS__)

/// The same for providers of boxes and masks (semantic/provider.hpp):
///     DYNFILTER_EXPORT_PROVIDERS(mine::MyDetector);
/// A module with both kinds instead writes
///     DYNFILTER_PLUGIN_TAG();
///     DYNFILTER_REGISTER_FILTERS(...);
///     DYNFILTER_REGISTER_PROVIDERS(...);
#define DYNFILTER_EXPORT_PROVIDERS(...) \
  DYNFILTER_PLUGIN_TAG();               \
  DYNFILTER_REGISTER_PROVIDERS(__VA_ARGS__)
