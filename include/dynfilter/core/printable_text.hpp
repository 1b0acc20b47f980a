// SPDX-License-Identifier: MIT
#pragma once

#include <charconv>
#include <cstddef>
#include <string>
#include <string_view>
#include <type_traits>

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

/// Columns of an error message for one text of a user.
inline constexpr std::size_t kMostQuotedColumns = 60;

namespace detail {

/// Bytes of the printable character at the begin. 0: none.
inline std::size_t printable_utf8_character(std::string_view text) {
  const auto byte = [&](std::size_t i) -> unsigned { return static_cast<unsigned char>(text[i]); };
  const unsigned first = byte(0);
  if (first < 0x80U) return first == '\t' || (first >= 32 && first != 127) ? 1 : 0;
  const std::size_t bytes = first < 0xC2U ? 0 : first < 0xE0U ? 2 : first < 0xF0U ? 3 : first < 0xF5U ? 4 : 0;
  if (bytes == 0 || bytes > text.size()) return 0;
  unsigned code = first & (0xFFU >> (bytes + 1));
  for (std::size_t i = 1; i < bytes; ++i) {
    if (!is_utf8_continuation(text[i])) return 0;
    code = code << 6U | (byte(i) & 0x3FU);
  }
  constexpr unsigned kLeast[] = {0, 0, 0xA0, 0x800,
                                 0x10000};  // below: controls, or a longer form than needed
  const bool is_surrogate = code >= 0xD800U && code <= 0xDFFFU;
  if (code < kLeast[bytes] || is_surrogate || code == 0xFFFEU || code == 0xFFFFU || code > 0x10FFFFU)
    return 0;
  return bytes;
}

}  // namespace detail

/// Number of bytes at the begin that are UTF-8 without control characters, surrogates and non-characters.
/// A tab is allowed.
inline std::size_t printable_utf8_bytes(std::string_view text) {
  std::size_t i = 0;
  while (i < text.size()) {
    const std::size_t bytes = detail::printable_utf8_character(text.substr(i));
    if (bytes == 0) break;
    i += bytes;
  }
  return i;
}

/// Whether the first byte cannot begin or continue a character of UTF-8, as in paths of other encodings.
inline bool is_of_other_encoding(std::string_view text) {
  const unsigned first = text.empty() ? 0U : static_cast<unsigned char>(text[0]);
  if (first < 0x80U) return false;
  const std::size_t more = first < 0xC2U ? 0 : first < 0xE0U ? 1 : first < 0xF0U ? 2 : first < 0xF5U ? 3 : 0;
  if (more == 0 || more >= text.size()) return true;
  for (std::size_t i = 1; i <= more; ++i)
    if (!is_utf8_continuation(text[i])) return true;
  return false;
}

/// The text as error messages quote it: between backticks, without control characters, and `...` instead of
/// what is beyond kMostQuotedColumns.
inline std::string in_backticks(std::string_view text) {
  constexpr std::size_t kMostBytes = 4 * kMostQuotedColumns;  // of text that is not UTF-8, too
  std::size_t columns = 0, end = 0;
  while (end < text.size() && end < kMostBytes &&
         (columns < kMostQuotedColumns || is_utf8_continuation(text[end])))
    columns += is_utf8_continuation(text[end++]) ? 0U : 1U;
  const char* dots = end < text.size() ? "..." : "";
  return "`" + without_controls(std::string(text.substr(0, end))) + dots + "`";
}

/// Without control characters, and with `...` in the middle if it has more than `most` bytes. `most` >= 16.
inline std::string one_bounded_line(const std::string& text, std::size_t most) {
  if (text.size() <= most) return without_controls(text);
  static constexpr std::string_view kDots = " ... ";
  // The end has the fault. The begin has the file.
  std::size_t head = (most - kDots.size()) / 3, tail = text.size() - (most - kDots.size() - head);
  while (head > 0 && is_utf8_continuation(text[head])) --head;
  while (tail < text.size() && is_utf8_continuation(text[tail])) ++tail;
  return without_controls(text.substr(0, head) + std::string(kDots) + text.substr(tail));
}

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
