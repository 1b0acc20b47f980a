// SPDX-License-Identifier: MIT
#include <dynfilter/core/printable_text.hpp>

#include "doctest/doctest.h"

namespace printable_text_test {

using dynfilter::without_controls;

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

}  // namespace printable_text_test
