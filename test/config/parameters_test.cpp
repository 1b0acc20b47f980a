// SPDX-License-Identifier: MIT
#include <cmath>
#include <dynfilter/config/parameters.hpp>

#include "doctest/doctest.h"

namespace parameters_test {

using namespace dynfilter;

namespace {

enum class Colour { Red, Green };

struct Example {
  double limit_px = 1.5;
  int count = 3;
  bool on = true;
  Colour colour = Colour::Red;
  std::vector<std::string> classes{"person"};

  static const FieldTable<Example>& fields() {
    static const FieldTable<Example> table{
        real("limit_px", &Example::limit_px, "px", {0, 10}, "a limit"),
        integer("count", &Example::count, "", {1, 5}, "a count"),
        flag("on", &Example::on, "a switch"),
        choice("colour", &Example::colour, {{"red", Colour::Red}, {"green", Colour::Green}}, "a colour"),
        words("classes", &Example::classes, "some words"),
    };
    return table;
  }
};

Example read(const std::string& text) {
  const auto document = YamlDocument::from_text(text);
  return read_parameters<Example>(*document.root().find("p"));
}

std::string error_of(const std::string& text) {
  try {
    read(text);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "no error";
}

}  // namespace

TEST_CASE("keys that are there replace the defaults, the others stay") {
  const Example e = read("p: { limit_px: 2, colour: green, on: false, classes: [dog, cat] }");
  CHECK(e.limit_px == 2.0);
  CHECK(e.count == 3);
  CHECK_FALSE(e.on);
  CHECK(e.colour == Colour::Green);
  CHECK(e.classes == std::vector<std::string>{"dog", "cat"});
}

TEST_CASE("each wrong parameter is named with its path and what was expected") {
  CHECK(
      error_of("p: { limit: 2 }") ==
      "p: unknown key `limit` (did you mean `limit_px`?); known keys: limit_px, count, on, colour, classes");
  CHECK(error_of("p: { limit_px: 11 }") == "p.limit_px: expected 0 to 10, got `11`");
  CHECK(error_of("p: { count: 0 }") == "p.count: expected 1 to 5, got `0`");
  CHECK(error_of("p: { count: 1.5 }") == "p.count: expected a whole number, got `1.5`");
  CHECK(error_of("p: { colour: blue }") == "p.colour: expected one of red, green, got `blue`");
  CHECK(error_of("p: { on: 3 }") == "p.on: expected true or false, got `3`");
  CHECK(error_of("p: [ 1 ]") == "p: expected `key: value` pairs, got a list");
}

TEST_CASE("parameters set in code are held against the same ranges, NaN included") {
  Example e;
  CHECK_NOTHROW(check_parameters(e));
  e.limit_px = std::nan("");
  CHECK_THROWS_AS(check_parameters(e, "example"), ConfigError);
  e = {};
  e.count = 6;
  CHECK_THROWS_WITH_AS(check_parameters(e, "example"), "example.count: expected 1 to 5, got `6`",
                       ConfigError);
}

TEST_CASE("the table describes itself") {
  const auto infos = describe_parameters<Example>();
  REQUIRE(infos.size() == 5);
  CHECK(infos[0].default_value == "1.5");
  CHECK(infos[0].unit == "px");
  CHECK(infos[0].range == "0 to 10");
  CHECK(infos[3].default_value == "red");
  CHECK(infos[4].default_value == "[person]");
}

}  // namespace parameters_test
