// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <nlohmann/json.hpp>

namespace dynfilter::command {

/// Keys in the order in which they are written.
using Json = nlohmann::ordered_json;

/// null for what is not a number: JSON has no NaN.
inline Json number_or_null(double value) {
  return std::isfinite(value) ? Json(value) : Json(nullptr);
}

}  // namespace dynfilter::command
