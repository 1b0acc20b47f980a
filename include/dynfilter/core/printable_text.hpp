// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

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

/// True for each byte of a UTF-8 character but its first.
constexpr bool is_utf8_continuation(char c) {
  return (static_cast<unsigned char>(c) & 0xC0U) == 0x80U;
}

/// Number of bytes at the begin that are UTF-8 without control characters, surrogates and non-characters.
/// A tab is allowed.
std::size_t printable_utf8_bytes(std::string_view text);

/// Whether the first byte cannot begin or continue a character of UTF-8, as in paths of other encodings.
bool is_of_other_encoding(std::string_view text);

/// Columns of an error message for one text of a user.
inline constexpr std::size_t kMostQuotedColumns = 60;

/// The text as error messages quote it: between backticks, without control characters,
/// and `...` instead of what is beyond kMostQuotedColumns.
std::string in_backticks(std::string_view text);

/// Without control characters, and with `...` in the middle if it has more than `most` bytes.
/// `most` >= 16.
std::string one_bounded_line(const std::string& text, std::size_t most);

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/core/detail/printable_text-inl.hpp>
#endif
