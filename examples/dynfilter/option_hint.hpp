// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/error.hpp>
#include <string>

namespace dynfilter::command {

/// What `f` returns. An error about a file says which option named it.
template <class F>
auto read_for(const char* option, const F& f) {
  try {
    return f();
  } catch (const Error& error) {
    throw IoError(std::string(option) + " " + error.what());
  }
}

/// What `f` returns. An error of this type says which option helps.
template <class E, class F>
auto with_hint(const char* hint, const F& f) {
  try {
    return f();
  } catch (const E& error) {
    throw IoError(std::string(error.what()) + hint);
  }
}

}  // namespace dynfilter::command
