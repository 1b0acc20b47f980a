// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstring>
#include <dynfilter/core/registry.hpp>
#include <exception>

namespace dynfilter::detail {

inline void copy_message(const char* text, char* out, std::size_t out_bytes) noexcept {
  if (out == nullptr || out_bytes == 0) return;
  std::strncpy(out, text, out_bytes - 1);
  out[out_bytes - 1] = '\0';
}

/// No exception leaves a plugin: what went wrong is handed back as text.
template <class... Filters>
int register_filters(Registry* registry, char* error, std::size_t error_bytes) noexcept {
  try {
    (registry->add<Filters>(), ...);
    return 0;
  } catch (const std::exception& e) {
    copy_message(e.what(), error, error_bytes);
  } catch (...) {
    copy_message("something that is no std::exception was thrown", error, error_bytes);
  }
  return 1;
}

}  // namespace dynfilter::detail

/// The second of a plugin's two functions; plugin/export.hpp makes both.
#define DYNFILTER_REGISTER_FILTERS(...)                                                    \
  extern "C" __attribute__((visibility("default"))) int dynfilter_plugin_register(         \
      dynfilter::Registry* registry, char* error, std::size_t error_bytes) noexcept {      \
    return dynfilter::detail::register_filters<__VA_ARGS__>(registry, error, error_bytes); \
  }                                                                                        \
  static_assert(true, "takes the semicolon")
