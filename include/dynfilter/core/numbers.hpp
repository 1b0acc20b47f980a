// SPDX-License-Identifier: MIT
#pragma once

#include <charconv>
#include <ios>
#include <limits>
#include <locale>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>

namespace dynfilter {

// Numbers as text, always with a decimal point.
// printf, strtod and streams use a decimal comma if the host has set such a locale.

/// A stream that reads words and numbers from a line, in the classic locale.
inline std::istringstream classic_input(const std::string& line) {
  std::istringstream in(line);
  in.imbue(std::locale::classic());
  return in;
}

/// A stream that writes numbers in the classic locale.
inline std::ostringstream classic_output() {
  std::ostringstream out;
  out.imbue(std::locale::classic());
  return out;
}

/// Formats like printf's %g, with at most `digits` significant digits.
inline std::string number_text(double value, int digits = 6) {
  std::ostringstream out = classic_output();
  out.precision(digits);
  out << value;
  return out.str();
}

/// Formats like printf's %f, with `decimals` digits after the point.
inline std::string fixed_text(double value, int decimals) {
  std::ostringstream out = classic_output();
  out.precision(decimals);
  out << std::fixed << value;
  return out.str();
}

namespace detail {

inline bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

/// True for [sign] digits [. digits] [e [sign] digits]
/// with at least one digit before the exponent.
inline bool has_number_syntax(std::string_view text) {
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

inline std::optional<double> parse_by_stream(std::string_view text) {
  std::istringstream in = classic_input(std::string(text));
  double value = 0;
  if (!(in >> value)) return std::nullopt;
  return value;
}

/// libc++ has no std::from_chars for double.
/// Where it exists, it is thirty times faster than a stream.
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

/// Parses the whole text as a number: "1.5x" is rejected, "nan", "inf" and "-inf" are accepted.
/// Returns nothing if the value does not fit a double.
inline std::optional<double> parse_number(std::string_view text) {
  if (text == "nan" || text == "-nan") return std::numeric_limits<double>::quiet_NaN();
  if (text == "inf" || text == "+inf") return std::numeric_limits<double>::infinity();
  if (text == "-inf") return -std::numeric_limits<double>::infinity();
  return detail::parse_finite(text);
}

}  // namespace dynfilter
