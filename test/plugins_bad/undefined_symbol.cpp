// SPDX-License-Identifier: MIT
// Needs an undefined function.
extern "C" int dynfilter_test_nobody_has_this();
// Exported, or the linker drops it as unused.
extern "C" __attribute__((visibility("default"))) int call() {
  return dynfilter_test_nobody_has_this();
}
