// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/error.hpp>

#include <dynfilter/core/inline.hpp>
#include <dynfilter/core/printable_text.hpp>

namespace dynfilter {

DYNFILTER_INLINE Error::Error(const std::string& message)
    : std::runtime_error(one_bounded_line(message, kMaxBytes)) {}

DYNFILTER_INLINE ConfigError::ConfigError(const std::string& path, const std::string& message)
    : Error(path.empty() ? message : path + ": " + message), path_(path) {}

}  // namespace dynfilter
