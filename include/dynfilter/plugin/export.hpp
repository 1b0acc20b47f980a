// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/plugin/abi.hpp>
#include <dynfilter/plugin/register.hpp>

/// The function that every plugin has.
#define DYNFILTER_PLUGIN_TAG()                                               \
  extern "C" __attribute__((visibility("default"))) const dynfilter::AbiTag* \
  dynfilter_plugin_tag() noexcept {                                          \
    static constexpr dynfilter::AbiTag tag = dynfilter::abi_tag();           \
    return &tag;                                                             \
  }                                                                          \
  static_assert(true, "takes the semicolon")

/// Exports filters from a loadable module.
/// Write this line in one source file, outside all namespaces:
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
