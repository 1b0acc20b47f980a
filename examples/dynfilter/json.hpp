// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

namespace dynfilter::command {

/// Keys in the order in which they are written.
using Json = nlohmann::ordered_json;

/// null for what is not a number: JSON has no NaN.
inline Json number_or_null(double value) {
  return std::isfinite(value) ? Json(value) : Json(nullptr);
}

/// Bytes that are not UTF-8 (of a folder's name, say, or of a provider's error) become U+FFFD: JSON has no
/// other place for them, and a run's results must not be lost for them.
inline std::string json_text(const Json& json) {
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace dynfilter::command
