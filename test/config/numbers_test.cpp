// SPDX-License-Identifier: MIT
#include <cmath>
#include <dynfilter/config/numbers.hpp>
#include <locale>

#include "doctest/doctest.h"
#include "support/comma_locale.hpp"

namespace numbers_test {

using namespace dynfilter;

TEST_CASE("numbers are read in full, and the same with and without from_chars") {
  for (const auto& [text, value] : {std::pair{"1.5", 1.5},
                                    {"+2", 2.0},
                                    {"-.5", -0.5},
                                    {"4.", 4.0},
                                    {"1e-3", 1e-3},
                                    {"1305031102.175304", 1305031102.175304},
                                    {"0.1", 0.1},
                                    {"1E+300", 1e300}}) {
    const auto& shown = text;  // clang 14 captures no structured binding
    CAPTURE(shown);
    CHECK(parse_number(text) == value);
    CHECK(detail::parse_by_stream(text) == value);
  }
  for (const char* text :
       {"", "+", "-", ".", "e5", "1e", "1.5x", " 1", "1 ", "1,5", "0x10", "1e999", "++1"}) {
    CAPTURE(text);
    CHECK_FALSE(parse_number(text));
  }
  CHECK_FALSE(detail::parse_by_stream("1e999"));
  CHECK(std::isnan(*parse_number("nan")));
  CHECK(std::isinf(*parse_number("-inf")));
}

TEST_CASE("numbers have a point, whatever the locale") {
  const dynfilter_test::CommaLocale locale;
  CHECK(parse_number("1234.5") == 1234.5);
  CHECK(detail::parse_by_stream("1234.5") == 1234.5);
  CHECK_FALSE(parse_number("1234,5"));
  CHECK(number_text(1234.5) == "1234.5");
  CHECK(number_text(0.1F, 9) == "0.100000001");
  CHECK(fixed_text(1305031102.175304, 6) == "1305031102.175304");
}

}  // namespace numbers_test
