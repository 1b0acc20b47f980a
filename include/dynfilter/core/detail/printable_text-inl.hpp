// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/printable_text.hpp>

#include <dynfilter/core/inline.hpp>

namespace dynfilter {

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

DYNFILTER_INLINE std::size_t printable_utf8_bytes(std::string_view text) {
  std::size_t i = 0;
  while (i < text.size()) {
    const std::size_t bytes = detail::printable_utf8_character(text.substr(i));
    if (bytes == 0) break;
    i += bytes;
  }
  return i;
}

DYNFILTER_INLINE bool is_of_other_encoding(std::string_view text) {
  const unsigned first = text.empty() ? 0U : static_cast<unsigned char>(text[0]);
  if (first < 0x80U) return false;
  const std::size_t more = first < 0xC2U ? 0 : first < 0xE0U ? 1 : first < 0xF0U ? 2 : first < 0xF5U ? 3 : 0;
  if (more == 0 || more >= text.size()) return true;
  for (std::size_t i = 1; i <= more; ++i)
    if (!is_utf8_continuation(text[i])) return true;
  return false;
}

DYNFILTER_INLINE std::string in_backticks(std::string_view text) {
  constexpr std::size_t kMostBytes = 4 * kMostQuotedColumns;  // of text that is not UTF-8, too
  std::size_t columns = 0, end = 0;
  while (end < text.size() && end < kMostBytes &&
         (columns < kMostQuotedColumns || is_utf8_continuation(text[end])))
    columns += is_utf8_continuation(text[end++]) ? 0U : 1U;
  const char* dots = end < text.size() ? "..." : "";
  return "`" + without_controls(std::string(text.substr(0, end))) + dots + "`";
}

DYNFILTER_INLINE std::string one_bounded_line(const std::string& text, std::size_t most) {
  if (text.size() <= most) return without_controls(text);
  static constexpr std::string_view kDots = " ... ";
  // The end has the fault. The begin has the file.
  std::size_t head = (most - kDots.size()) / 3, tail = text.size() - (most - kDots.size() - head);
  while (head > 0 && is_utf8_continuation(text[head])) --head;
  while (tail < text.size() && is_utf8_continuation(text[tail])) ++tail;
  return without_controls(text.substr(0, head) + std::string(kDots) + text.substr(tail));
}

}  // namespace dynfilter
