// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <sstream>
#include <string>
#include <string_view>

namespace dynfilter {

// Numbers as text, always with a decimal point.
// printf, strtod and streams use a decimal comma if the host has set such a locale.

/// A stream that reads words and numbers from a line, in the classic locale.
std::istringstream classic_input(const std::string& line);

/// A stream that writes numbers in the classic locale.
std::ostringstream classic_output();

/// Formats like printf's %g, with at most `digits` significant digits.
std::string number_text(double value, int digits = 6);

/// "0 to 5", or ">= 0" where the upper end is 1e9 or more, which stands for none.
std::string range_text(double min, double max);

/// Formats like printf's %f, with `decimals` digits after the point.
std::string fixed_text(double value, int decimals);

namespace detail {

inline bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

/// True for [sign] digits [. digits] [e [sign] digits] with at least one digit before the exponent.
bool has_number_syntax(std::string_view text);

std::optional<double> parse_by_stream(std::string_view text);

}  // namespace detail

/// Parses the whole text as a number: "1.5x" is rejected, "nan", "inf" and "-inf" are accepted.
/// Returns nothing if the value does not fit a double.
std::optional<double> parse_number(std::string_view text);

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/config/detail/numbers-inl.hpp>
#endif
