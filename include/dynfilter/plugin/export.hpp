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

/// Makes a loadable module export its filters: one line in one source file, outside every namespace.
///     DYNFILTER_EXPORT_FILTERS(mine::MyFilter, mine::OtherFilter);
#define DYNFILTER_EXPORT_FILTERS(...) \
  DYNFILTER_PLUGIN_TAG();             \
  DYNFILTER_REGISTER_FILTERS(__VA_ARGS__)

/// The same for providers of boxes and masks (semantic/provider.hpp).
///     DYNFILTER_EXPORT_PROVIDERS(mine::MyDetector);
/// A module with both kinds writes DYNFILTER_PLUGIN_TAG(); DYNFILTER_REGISTER_FILTERS(...); and
/// DYNFILTER_REGISTER_PROVIDERS(...); instead.
#define DYNFILTER_EXPORT_PROVIDERS(...) \
  DYNFILTER_PLUGIN_TAG();               \
  DYNFILTER_REGISTER_PROVIDERS(__VA_ARGS__)
