// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/error.hpp>

#include <dynfilter/core/inline.hpp>

namespace dynfilter {

DYNFILTER_INLINE ConfigError::ConfigError(const std::string& path, const std::string& message)
    : Error(path.empty() ? message : path + ": " + message), path_(path) {}

}  // namespace dynfilter
