// SPDX-License-Identifier: MIT
// Needs an undefined function.
extern "C" int dynfilter_test_nobody_has_this();
extern "C" int call() {
  return dynfilter_test_nobody_has_this();
}
