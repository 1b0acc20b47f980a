// SPDX-License-Identifier: MIT
// Needs a function that nobody has.
extern "C" int dynfilter_test_nobody_has_this();
extern "C" int call() {
  return dynfilter_test_nobody_has_this();
}
