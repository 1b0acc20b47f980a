// SPDX-License-Identifier: MIT
#pragma once

#include <charconv>
#include <string>
#include <type_traits>

namespace dynfilter {

/// Appends texts and integers. Allocates nothing but the room of `to`.
template <class... Parts>
void append_text(std::string& to, const Parts&... parts) {
  const auto append = [&to](const auto& part) {
    if constexpr (std::is_integral_v<std::decay_t<decltype(part)>>) {
      char digits[24];  // a 64-bit integer with its sign
      to.append(digits, std::to_chars(digits, digits + sizeof(digits), part).ptr);
    } else {
      to += part;
    }
  };
  (append(parts), ...);
}

}  // namespace dynfilter
