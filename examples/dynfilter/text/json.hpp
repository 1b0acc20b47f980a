// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

namespace dynfilter::command {

/// Keys are written in insertion order.
using Json = nlohmann::ordered_json;

/// null for NaN and infinity, which JSON does not have.
inline Json number_or_null(double value) {
  return std::isfinite(value) ? Json(value) : Json(nullptr);
}

/// JSON text. Bytes that are not UTF-8 become U+FFFD, so that no results are lost.
/// They may come from a folder's name or a provider's error.
inline std::string json_text(const Json& json) {
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace dynfilter::command
