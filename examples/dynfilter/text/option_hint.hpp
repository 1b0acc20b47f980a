// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/error.hpp>
#include <string>

namespace dynfilter::command {

/// Calls `f`. Adds the option that named a file to errors about the file.
template <class F>
auto read_for(const char* option, const F& f) {
  try {
    return f();
  } catch (const Error& error) {
    throw IoError(std::string(option) + " " + error.what());
  }
}

/// Calls `f`. Adds the option that helps to errors of this type.
template <class E, class F>
auto with_hint(const char* hint, const F& f) {
  try {
    return f();
  } catch (const E& error) {
    throw IoError(std::string(error.what()) + hint);
  }
}

}  // namespace dynfilter::command
