// SPDX-License-Identifier: MIT
// A library, but not a plugin: it has neither of the two functions.
extern "C" int answer() {
  return 42;
}
