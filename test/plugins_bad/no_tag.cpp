// SPDX-License-Identifier: MIT
// A library, but no plugin: neither of the two functions is there.
extern "C" int answer() {
  return 42;
}
