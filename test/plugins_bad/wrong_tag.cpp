// SPDX-License-Identifier: MIT
// Built for another ABI: field number DYNFILTER_TEST_WRONG_FIELD is off by one.
// Its registration crashes, which proves that nothing is called after the comparison.
#include <cstdlib>
#include <dynfilter/plugin/abi.hpp>

extern "C" __attribute__((visibility("default"))) const dynfilter::AbiTag* dynfilter_plugin_tag() noexcept {
  static dynfilter::AbiTag tag;
  tag = dynfilter::abi_tag();
  const char* field = std::getenv("DYNFILTER_TEST_WRONG_FIELD");
  if (field != nullptr) tag.*dynfilter::kAbiFields[std::atoi(field)].value += 1;
  return &tag;
}
extern "C" __attribute__((visibility("default"))) int dynfilter_plugin_register(dynfilter::Registry*, char*,
                                                                                std::size_t) noexcept {
  std::abort();
}
