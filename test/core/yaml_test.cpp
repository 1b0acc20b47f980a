// SPDX-License-Identifier: MIT
#include <dynfilter/core/yaml.hpp>

#include "doctest/doctest.h"

using dynfilter::ConfigError;
using dynfilter::YamlDocument;

namespace {

std::string error_of(const std::string& text, void (*read)(const dynfilter::YamlNode&)) {
  try {
    const YamlDocument document = YamlDocument::from_text(text, "file.yaml");
    read(document.root());
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "no error";
}

}  // namespace

TEST_CASE("values of the right type are read") {
  const auto document = YamlDocument::from_text(
      "a: 1\nb: 2.5\nc: true\nd: false # a comment\ne: word # comment\nf: [x, \"y z\"]\ng: { h: -3 }\n");
  const auto root = document.root();
  CHECK(root.find("a")->integer() == 1);
  CHECK(root.find("a")->real() == 1.0);
  CHECK(root.find("b")->real() == 2.5);
  CHECK(root.find("c")->flag());
  CHECK_FALSE(root.find("d")->flag());
  CHECK(root.find("e")->text() == "word");
  CHECK(root.find("f")->texts() == std::vector<std::string>{"x", "y z"});
  CHECK(root.find("g")->find("h")->integer() == -3);
  CHECK(root.find("g")->find("h")->path() == "g.h");
  CHECK_FALSE(root.find("missing").has_value());
}

TEST_CASE("what OpenCV would silently misread is an error that names the path") {
  using Node = dynfilter::YamlNode;
  CHECK(error_of("x: abc", [](const Node& n) { n.find("x")->real(); }) == "x: expected a number, got `abc`");
  CHECK(error_of("x: \"1.5\"", [](const Node& n) { n.find("x")->real(); }) ==
        "x: expected a number, got `1.5`");
  CHECK(error_of("x: 3.7", [](const Node& n) { n.find("x")->integer(); }) ==
        "x: expected a whole number, got `3.7`");
  CHECK(error_of("x: .inf", [](const Node& n) { n.find("x")->real(); }) ==
        "x: expected a finite number, got `inf`");
  CHECK(error_of("x: maybe", [](const Node& n) { n.find("x")->flag(); }) ==
        "x: expected true or false, got `maybe`");
  CHECK(error_of("x: 2", [](const Node& n) { n.find("x")->flag(); }) == "x: expected true or false, got `2`");
  CHECK(error_of("x: 1", [](const Node& n) { n.find("x")->text(); }) == "x: expected a word, got `1`");
  CHECK(error_of("x: 1", [](const Node& n) { n.find("x")->items(); }) == "x: expected a list, got `1`");
  CHECK(error_of("m: { a: 1, b: 2, a: 3 }", [](const Node& n) { n.find("m")->entries(); }) ==
        "m: key `a` is written twice");
  CHECK(error_of("l: [ 1, { a: x } ]", [](const Node& n) { n.find("l")->items()[1].find("a")->real(); }) ==
        "l[1].a: expected a number, got `x`");
}

TEST_CASE("a text that is not YAML is an error that names the file and the line") {
  using Node = dynfilter::YamlNode;
  const auto nothing = [](const Node&) {};
  CHECK(error_of("a: [1\n", nothing).find("file.yaml: not valid YAML: line ") == 0);
  CHECK(error_of("hello world\n", nothing).find("file.yaml: not valid YAML: line ") == 0);
  CHECK(error_of("", nothing) == "file.yaml: expected `key: value` pairs, found none");
  CHECK(error_of("- a\n- b\n", nothing) == "file.yaml: expected `key: value` pairs, found none");
  CHECK(error_of(std::string("\x89PNG\r\n\x1a\n\0\0", 10), nothing).find("file.yaml: ") == 0);
  CHECK_THROWS_AS(YamlDocument::from_file("/does/not/exist.yaml"), ConfigError);
}
