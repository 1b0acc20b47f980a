// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/config/numbers.hpp>

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <dynfilter/core/inline.hpp>
#include <limits>
#include <locale>
#include <system_error>

namespace dynfilter {

DYNFILTER_INLINE std::istringstream classic_input(const std::string& line) {
  std::istringstream in(line);
  in.imbue(std::locale::classic());
  return in;
}

DYNFILTER_INLINE std::ostringstream classic_output() {
  std::ostringstream out;
  out.imbue(std::locale::classic());
  return out;
}

DYNFILTER_INLINE std::string number_text(double value, int digits) {
  std::ostringstream out = classic_output();
  out.precision(digits);
  out << value;
  return out.str();
}

/// Digits of the largest double before the point.
inline constexpr std::size_t kMostDigits = std::numeric_limits<double>::max_exponent10 + 1;

DYNFILTER_INLINE std::string range_text(double min, double max) {
  constexpr double kNoEnd = 1e9;
  return max >= kNoEnd ? ">= " + number_text(min) : number_text(min) + " to " + number_text(max);
}

DYNFILTER_INLINE std::string fixed_text(double value, int decimals) {
  char text[kMostDigits + 64];  // with a sign, a point and usual decimals
  const auto end =
      std::to_chars(text, text + sizeof(text), value, std::chars_format::fixed, std::clamp(decimals, 0, 60));
  return {text, end.ptr};
}

namespace detail {

DYNFILTER_INLINE bool has_number_syntax(std::string_view text) {
  std::size_t i = 0;
  const auto sign = [&] { i += i < text.size() && (text[i] == '+' || text[i] == '-') ? 1U : 0U; };
  const auto digits = [&] {
    const std::size_t from = i;
    while (i < text.size() && is_digit(text[i])) ++i;
    return i - from;
  };
  sign();
  std::size_t found = digits();
  if (i < text.size() && text[i] == '.') {
    ++i;
    found += digits();
  }
  if (found == 0) return false;
  if (i < text.size() && (text[i] == 'e' || text[i] == 'E')) {
    ++i;
    sign();
    if (digits() == 0) return false;
  }
  return i == text.size();
}

DYNFILTER_INLINE std::optional<double> parse_by_stream(std::string_view text) {
  std::istringstream in = classic_input(std::string(text));
  double value = 0;
  if (!(in >> value)) return std::nullopt;
  return value;
}

/// libc++ has no std::from_chars for double. Where it exists, it is thirty times faster than a stream.
inline std::optional<double> parse_finite(std::string_view text) {
  if (!has_number_syntax(text)) return std::nullopt;
  if (text[0] == '+') text.remove_prefix(1);
#if defined(__cpp_lib_to_chars)
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
#else
  return parse_by_stream(text);
#endif
}

}  // namespace detail

DYNFILTER_INLINE std::optional<double> parse_number(std::string_view text) {
  if (text == "nan" || text == "-nan") return std::numeric_limits<double>::quiet_NaN();
  if (text == "inf" || text == "+inf") return std::numeric_limits<double>::infinity();
  if (text == "-inf") return -std::numeric_limits<double>::infinity();
  return detail::parse_finite(text);
}

}  // namespace dynfilter
