// SPDX-License-Identifier: MIT
// Has a tag that is right, but nothing to register with.
#include <dynfilter/plugin/abi.hpp>

extern "C" __attribute__((visibility("default"))) const dynfilter::AbiTag* dynfilter_plugin_tag() noexcept {
  static constexpr dynfilter::AbiTag tag = dynfilter::abi_tag();
  return &tag;
}
