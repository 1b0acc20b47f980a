// SPDX-License-Identifier: MIT
#include <dynfilter/core/printable_text.hpp>

#include "doctest/doctest.h"

namespace printable_text_test {

using namespace dynfilter;

TEST_CASE("control characters become question marks, other text stays") {
  CHECK(without_controls("") == "");
  CHECK(without_controls("cell phone ~ Stra\xC3\x9F"
                         "e") ==
        "cell phone ~ Stra\xC3\x9F"
        "e");
  CHECK(without_controls("a\x1B[31mb\r\n\t\x7F") == "a?[31mb????");
  CHECK(without_controls(std::string("a\0b", 3)) == "a?b");
  // U+009B is the control sequence introducer, U+00A9 the copyright sign.
  CHECK(without_controls("\xC2\x9B"
                         "31m \xC2\xA9") == "??31m \xC2\xA9");
}

TEST_CASE("quoted text is cut between characters") {
  std::string accents;
  for (int i = 0; i < 61; ++i) accents += "\xC3\xA9";
  CHECK(in_backticks("a\nb") == "`a?b`");
  CHECK(in_backticks(std::string(60, 'a')) == "`" + std::string(60, 'a') + "`");
  CHECK(in_backticks(accents) == "`" + accents.substr(0, 120) + "...`");
  CHECK(in_backticks(std::string(9000, '\x80')).size() == 2 + 240 + 3);
}

TEST_CASE("a bounded line keeps its begin and its end") {
  CHECK(one_bounded_line("short\n", 16) == "short?");
  CHECK(one_bounded_line("0123456789abcdefghij", 17) == "0123 ... cdefghij");
  for (std::size_t most = 16; most < 40; ++most) {
    const std::string line = one_bounded_line(std::string(50, 'x') + "\xC3\xA9" + std::string(20, 'y'), most);
    CHECK(line.size() <= most);
    CHECK(printable_utf8_bytes(line) == line.size());
  }
}

TEST_CASE("printable UTF-8 ends at control characters, surrogates and wrong bytes") {
  CHECK(printable_utf8_bytes("a\t\xC3\xA9\xE2\x82\xAC\xF0\x9F\x98\x80") == 11);
  for (const char* wrong :
       {"\n", "\x7F", "\x80", "\xC2\x9B", "\xC0\xAF", "\xE0\x80\xAF", "\xED\xA0\x80", "\xEF\xBF\xBE",
        "\xF4\x90\x80\x80", "\xF5\x80\x80\x80", "\xC3", "\xE2\x82", "\xC3("})
    CHECK(printable_utf8_bytes(std::string("ab") + wrong) == 2);
}

}  // namespace printable_text_test
