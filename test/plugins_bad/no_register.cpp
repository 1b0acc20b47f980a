// SPDX-License-Identifier: MIT
// Has a tag that is right (tag.cpp), but nothing to register with.
extern "C" int something_else() {
  return 0;
}
