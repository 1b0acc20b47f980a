// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/plugin/abi.hpp>
#include <dynfilter/plugin/register.hpp>

/// The first of a plugin's two functions.
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
