// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <string>

namespace dynfilter {

/// Replaces control characters by `?`: bytes below 32, 127, and those of UTF-8 from U+0080 to U+009F.
/// Text of files and of other programs may be printed on a terminal, which would obey them.
inline std::string without_controls(std::string text) {
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto byte = static_cast<unsigned char>(text[i]);
    const auto last = i > 0 ? static_cast<unsigned char>(text[i - 1]) : 0U;
    if (byte < 32 || byte == 127) text[i] = '?';
    if (last == 0xC2U && byte >= 0x80U && byte <= 0x9FU) text[i - 1] = text[i] = '?';
  }
  return text;
}

}  // namespace dynfilter
