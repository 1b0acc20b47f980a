// SPDX-License-Identifier: MIT
// Has a correct tag (tag.cpp), but no function to register.
extern "C" int something_else() {
  return 0;
}
