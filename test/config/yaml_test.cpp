// SPDX-License-Identifier: MIT
#include <cstdint>
#include <dynfilter/config/yaml.hpp>
#include <dynfilter/config/yaml_text.hpp>
#include <filesystem>
#include <iterator>
#include <opencv2/core.hpp>

#include "doctest/doctest.h"
#include "support/time_limit.hpp"

namespace yaml_test {

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
        "x: expected a finite number, got `.inf`");
  CHECK(error_of("x: maybe", [](const Node& n) { n.find("x")->flag(); }) ==
        "x: expected true or false, got `maybe`");
  CHECK(error_of("x: 2", [](const Node& n) { n.find("x")->flag(); }) == "x: expected true or false, got `2`");
  CHECK(error_of("x: 1", [](const Node& n) { n.find("x")->text(); }) ==
        "x: expected a word, got `1`, which needs quotes as a word");
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

namespace {

const auto kNothing = [](const dynfilter::YamlNode&) {};

/// The error of a text without its "file.yaml: not valid YAML: ".
std::string syntax_error(const std::string& text) {
  const std::string error = error_of(text, kNothing), begin = "file.yaml: not valid YAML: ";
  return error.rfind(begin, 0) == 0 ? error.substr(begin.size()) : error;
}

void check_equal(const dynfilter::YamlNode& ours, const cv::FileNode& theirs) {
  CAPTURE(ours.path());
  REQUIRE(ours.is_map() == theirs.isMap());
  REQUIRE(ours.is_sequence() == theirs.isSeq());
  if (ours.is_map()) {
    const auto entries = ours.entries();
    REQUIRE(entries.size() == theirs.size());
    for (const auto& [key, value] : entries) check_equal(value, theirs[key]);
  } else if (ours.is_sequence()) {
    const auto items = ours.items();
    REQUIRE(items.size() == theirs.size());
    for (std::size_t i = 0; i < items.size(); ++i) check_equal(items[i], theirs[static_cast<int>(i)]);
  } else if (theirs.isString()) {
    const std::string text = theirs.string();  // which preserves comments
    CHECK(ours.text() == text.substr(0, text.find_last_not_of(' ', text.find(" #")) + 1));
  } else {
    CHECK(ours.real() == theirs.real());
  }
}

std::string integer_of(const std::string& number) {
  const YamlDocument document = YamlDocument::from_text("x: " + number);
  try {
    return std::to_string(document.root().find("x")->integer());
  } catch (const ConfigError& error) {
    return error.what();
  }
}

}  // namespace

TEST_CASE("a settings file of ORB-SLAM reads as OpenCV reads it") {
  const auto document = YamlDocument::from_text(
      "\xEF\xBB\xBF%YAML:1.0\r\n\r\n# a comment: with a colon\t\r\n---\r\nCamera.fx: 535.4\t\r\n"
      "Viewer.PointSize:2\nCamera.type: \"PinHole\"  # quoted # twice\nTbc: !!opencv-matrix\n   rows: 2\n"
      "   dt: f\n   data: [1.0, -2e-3,\n     .5, 4.] # rows\nList:\n- a # one\n-\n  b\n- c: 1\n  d: [\n]\n"
      "- - x\n  - \"y\"\nurl: file:///a#b\nsaid: 'it''s {here}, [there]'\n...\n# the end\n");
  const auto root = document.root();
  CHECK(root.find("Camera.fx")->real() == 535.4);
  CHECK(root.find("Viewer.PointSize")->integer() == 2);
  CHECK(root.find("Camera.type")->text() == "PinHole");
  CHECK(root.find("Tbc")->find("rows")->integer() == 2);
  CHECK(root.find("Tbc")->find("data")->reals() == std::vector<double>{1, -0.002, 0.5, 4});
  const auto list = root.find("List")->items();
  REQUIRE(list.size() == 4);
  CHECK(list[0].text() == "a");
  CHECK(list[1].text() == "b");
  CHECK(list[2].find("c")->integer() == 1);
  CHECK(list[2].find("d")->items().empty());
  CHECK(list[3].texts() == std::vector<std::string>{"x", "y"});
  CHECK(root.find("url")->text() == "file:///a#b");
  CHECK(root.find("said")->text() == "it's {here}, [there]");
}

TEST_CASE("every file of ours reads as OpenCV's own parser reads it") {
  std::size_t files = 0;
  for (const char* folder : {"/examples/pipelines", "/examples/detectors"})
    for (const auto& entry :
         std::filesystem::directory_iterator(std::string(DYNFILTER_SOURCE_DIR) + folder)) {
      CAPTURE(entry.path());
      const auto document = YamlDocument::from_file(entry.path().string());
      check_equal(document.root(), cv::FileStorage(entry.path().string(), cv::FileStorage::READ).root());
      ++files;
    }
  CHECK(files > 20);
}

TEST_CASE("texts that kept OpenCV's parser for ever or broke it are errors") {
  CHECK(syntax_error("pipeline:\n  before_pose: semantic_box\n...\n- epipolar\n") ==
        "line 4, column 1: text after the end of the document");
  CHECK(syntax_error(" L:0\n--\n#\n-") == "line 2, column 1: unexpected indentation");
  CHECK(syntax_error("  : x") == "line 1, column 3: an empty key");
  CHECK(syntax_error("a: { : x }") == "line 1, column 6: an empty key");
  CHECK(syntax_error("a: 1\n---\nb: 2\n") == "line 2, column 1: a second document");
  CHECK(syntax_error("---\n---\n") == "line 2, column 1: a second document");
  CHECK(syntax_error(std::string("a: 1\n\0b: 2\n", 11)) == "line 2, column 1: a control byte (0)");
}

TEST_CASE("depth and size are limited, whatever the nesting is made of") {
  const auto nested = [](const std::string& open, std::size_t n, const std::string& close) {
    std::string text = "a: ";
    for (std::size_t i = 0; i < n; ++i) text += open;
    text += "1";
    for (std::size_t i = 0; i < n; ++i) text += close;
    return syntax_error(text);
  };
  // The value of the root's key is at depth 2, so the 64th bracket is too deep. The first is in column 4.
  const auto too_deep = [](int columns_of_bracket) {
    return "line 1, column " + std::to_string(4 + 63 * columns_of_bracket) + ": nested more than 64 deep";
  };
  for (const std::size_t n : {std::size_t{65}, std::size_t{9600}}) {
    CHECK(nested("[", n, "]") == too_deep(1));
    CHECK(nested("{b: ", n, "}") == too_deep(4));
  }
  CHECK(nested("[", 60, "]") == "no error");
  std::string dashes = "a:\n  ", maps;
  for (int i = 0; i < 9600; ++i) dashes += "- ";
  CHECK(syntax_error(dashes + "x") == "line 2, column 129: nested more than 64 deep");
  for (int i = 0; i < 100; ++i) maps += std::string(static_cast<std::size_t>(i), ' ') + "a:\n";
  CHECK(syntax_error(maps) == "line 65, column 65: nested more than 64 deep");
  CHECK(syntax_error("a: " + std::string(300000, 'x')) == "expected at most 256 kB");
}

TEST_CASE("whole numbers are checked before they wrap") {
  CHECK(integer_of("2147483647") == "2147483647");
  CHECK(integer_of("-2147483648") == "-2147483648");
  CHECK(integer_of("+7") == "7");
  CHECK(integer_of("2147483648") == "x: expected a whole number of 32 bits, got `2147483648`");
  CHECK(integer_of("4294967346") == "x: expected a whole number of 32 bits, got `4294967346`");
  CHECK(integer_of("99999999999999999999999") ==
        "x: expected a whole number of 32 bits, got `99999999999999999999999`");
  for (const char* other : {"010", "0x10", "1e3", "1.0", "--1", "1_000", "\"1\"", "[1]"}) {
    CAPTURE(other);
    CHECK(integer_of(other).rfind("x: expected a whole number, got ", 0) == 0);
  }
  CHECK(error_of("x: 1e999", [](const dynfilter::YamlNode& n) { n.find("x")->real(); }) ==
        "x: expected a finite number, got `1e999`");
}

TEST_CASE("other mistakes: one line that names the line") {
  CHECK(syntax_error("a: 1\n  b: 2\n") == "line 2, column 3: unexpected indentation");
  CHECK(syntax_error("a:\n    b: 1\n  c: 2\n") == "line 3, column 3: unexpected indentation");
  CHECK(syntax_error("a:\nb: 1\n") == "line 1, column 3: expected a value after the key");
  CHECK(syntax_error("a:\n  -\nb: 1\n") == "line 2, column 3: expected a value after `-`");
  CHECK(syntax_error("a: b: c\n") == "line 1, column 5: a value with `: ` in it needs quotes");
  CHECK(syntax_error("a: - b\n") == "line 1, column 4: a list begins in a line of its own, or in brackets");
  CHECK(syntax_error("a:\n\tb: 1\n") == "line 2, column 2: a tab in the indentation");
  CHECK(syntax_error("a: \"b\n") == "line 1, column 4: a quote that is not closed in its line");
  CHECK(syntax_error("a: \"b\" c\n") == "line 1, column 8: unexpected text after the value");
  CHECK(syntax_error("a: [1\nb: 2\n") == "line 2, column 1: expected `,` or `]`");
  CHECK(syntax_error("\na: [1, {b: 2}\n\n") == "line 2, column 4: a bracket that is not closed");
  CHECK(syntax_error("a: {b: 1]\n") == "line 1, column 9: expected `,` or `}`");
  CHECK(syntax_error("a: |\n  text\n") == "line 1, column 4: a value that begins with `|` needs quotes");
  CHECK(syntax_error("a: *b\n") == "line 1, column 4: a value that begins with `*` needs quotes");
}

TEST_CASE("every line break of YAML ends a line and a comment, and others are errors") {
  const auto stages = [](const std::string& line_break) {
    std::string text = "a:|  - x # note|  - y|b: 1|";
    for (std::size_t at = 0; (at = text.find('|', at)) != std::string::npos; at += line_break.size())
      text.replace(at, 1, line_break);
    return YamlDocument::from_text(text).root().find("a")->texts();
  };
  for (const char* line_break : {"\n", "\r\n", "\r"}) CHECK(stages(line_break).size() == 2);
  CHECK(stages("\r\r\n") == std::vector<std::string>{"x", "y"});
  CHECK(syntax_error("\ra: 1\r\n  b: 2") == "line 3, column 3: unexpected indentation");
  for (const char* hidden : {"\xC2\x85", "\xE2\x80\xA8", "\xE2\x80\xA9"})
    CHECK(syntax_error("a: 1\n# \xC3\xA9" + std::string(hidden) + "b: 2\n") ==
          "line 2, column 4: a line break that most editors do not show (U+0085, U+2028 or U+2029)");
}

TEST_CASE("no property of a key or value becomes part of its text") {
  for (const char* c : {"&", "*", "!", "?", "|", ">", "%", "@", "`", "[", "]", "{", "}", ","}) {
    const std::string mark = c;
    CAPTURE(mark);
    for (const char* key : {"x: 1", "x : 1", " x: 1", "!str x: 1", "x]: 1", "x}: 1"}) {
      CHECK(syntax_error("a: 1\n" + mark + key + "\nb: 2\n") != "no error");
      CHECK(syntax_error("a:\n  - " + mark + key + "\n") != "no error");
      CHECK(syntax_error("a: { " + mark + key + " }\n") != "no error");
    }
    CHECK(syntax_error("a: " + mark + "x\n") != "no error");
    CHECK(syntax_error("a: [1, " + mark + "x]\n") != "no error");
  }
  CHECK(syntax_error("&x a: 1") == "line 1, column 1: a key that begins with `&` needs quotes");
  CHECK(syntax_error("a: !!str 1") == "line 1, column 4: a tag: only `!!opencv-matrix` is known");
  CHECK(syntax_error("a: !!opencv-matrix 1") == "line 1, column 20: expected a map after the tag");
  CHECK(syntax_error("a:\n  - !!opencv-matrix rows: 1\n") ==
        "line 2, column 21: expected a map after the tag");
  CHECK(syntax_error("<<: { a: 1 }") == "line 1, column 3: a merge key (`<<`)");
}

TEST_CASE("directives, marks and texts that PyYAML refuses are errors") {
  CHECK(syntax_error("%TAG ! tag:x,2000:\n---\na: 1\n") ==
        "line 1, column 1: a directive: expected `%YAML:1.0` or none");
  CHECK(syntax_error("%YAML:2.0\na: 1\n") == "line 1, column 1: a directive: expected `%YAML:1.0` or none");
  CHECK(syntax_error("%YAML:1.0\n%YAML:1.0\na: 1\n") ==
        "line 2, column 1: a key that begins with `%` needs quotes");
  CHECK(syntax_error("a: [\n---\n]\n") == "line 2, column 1: a document marker inside brackets");
  CHECK(syntax_error("a: 1\n\xEF\xBB\xBF"
                     "b: 2\n") == "line 2, column 1: a byte order mark inside the text");
  CHECK(syntax_error("a: 'x\xC2\x9B'") == "line 1, column 6: a character that is not printable");
  // Paths may have bytes of another encoding.
  CHECK(syntax_error("a: \xC3\xA9\xFF") == "no error");
  CHECK(YamlDocument::from_text("a: caf\xE9").root().find("a")->text() == "caf\xE9");
  CHECK(syntax_error("a: 1 # \xFF of any encoding") == "no error");
  CHECK(syntax_error("a: {b:1}") == "line 1, column 6: expected a blank after `:`");
  CHECK(syntax_error("a: [b:]") == "line 1, column 6: a value with `:` in it needs quotes in brackets");
  CHECK(syntax_error(std::string(1025, 'k') + ": 1") == "line 1, column 1026: a key of more than 1024 bytes");
  CHECK(YamlDocument::from_text("{ a: 1 }").root().find("a")->integer() == 1);
  const YamlDocument escaped = YamlDocument::from_text("x:\n  - \"a\\\": b\": 1\n  - \"a\\\": b\"\n");
  CHECK(escaped.root().find("x")->items()[0].find("a\": b")->integer() == 1);
  CHECK(escaped.root().find("x")->items()[1].text() == "a\": b");
}

TEST_CASE("what YAML 1.1 takes for a number, a date or null is no word without quotes") {
  for (const char* other : {"010",
                            "0x1F",
                            "0b11",
                            "1_000",
                            "1:30",
                            "1:30.5",
                            "1_0.5",
                            "1.5e3",
                            ".5",
                            "+.inf",
                            ".NaN",
                            "~",
                            "null",
                            "NULL",
                            "2011_09_26",
                            "2024-1-31",
                            "2024-01-31T10:00:00",
                            "2024-01-31 10:00",
                            "=",
                            "<<"}) {
    CAPTURE(other);
    const auto text = [](const dynfilter::YamlNode& n) { n.find("x")->text(); };
    CHECK(error_of("x: " + std::string(other), text).rfind("x: expected a word, got `", 0) == 0);
    CHECK(error_of("x: '" + std::string(other) + "'", text) == "no error");
  }
  for (const char* word : {"3d", "off", "yes", "true", "0xyz", "1.2.3", "2024-01", "e5", "-a", "_1", "1e",
                           "a:b", "dynfilter", "2024-01-31.yaml"}) {
    CAPTURE(word);
    CHECK(YamlDocument::from_text("x: " + std::string(word)).root().find("x")->text() == word);
  }
  const auto flag = [](const dynfilter::YamlNode& n) { n.find("x")->flag(); };
  for (const char* other : {"yes", "on", "True", "'true'", "\"1\""})
    CHECK(error_of("x: " + std::string(other), flag).rfind("x: expected true or false, got `", 0) == 0);
}

TEST_CASE("error texts are short and of one line, whatever they quote") {
  const std::string huge(200000, 'x');
  const auto name = [](const dynfilter::YamlNode& n) { n.find("a")->real(); };
  CHECK(error_of("a: " + huge, name) == "a: expected a number, got `" + std::string(60, 'x') + "...`");
  CHECK(error_of("a: \"x\\n\\ty\"", name) == "a: expected a number, got `x??y`");
  const auto twice = [](const dynfilter::YamlNode& n) { n.entries(); };
  const std::string key(1000, 'k');
  CHECK(error_of(key + ": 1\n" + key + ": 2\n", twice) ==
        "key `" + std::string(60, 'k') + "...` is written twice");
  std::string nested;
  for (int i = 0; i < 60; ++i) nested += "{ " + key + ": ";
  const auto deepest = [](const dynfilter::YamlNode& n) {
    dynfilter::YamlNode node = n;
    while (node.is_map()) node = node.entries().front().second;
    node.real();
  };
  const std::string error = error_of(nested + "word" + std::string(60, '}'), deepest);
  CHECK(error.size() <= dynfilter::Error::kMaxBytes);
  CHECK(error.find("expected a number, got `word`") != std::string::npos);
}

TEST_CASE("any bytes are a document or a ConfigError") {
  const std::string pieces[] = {"a",  ":",  " ", "\n", "- ",   "[",   "]",    "{",  "}",
                                ",",  "\"", "'", "#",  "...",  "---", "!",    "\\", "%",
                                "\t", "\r", "0", ".",  "\xFF", "a: ", "\n  ", "1"};
  std::uint32_t state = 1;
  const auto next = [&](std::size_t n) {
    state = state * 1664525U + 1013904223U;
    return static_cast<std::size_t>(state >> 8U) % n;
  };
  int documents = 0;
  for (int k = 0; k < 50000; ++k) {
    std::string text = k % 2 == 0 ? "a: " : "";
    for (std::size_t i = next(12); i > 0; --i) text += pieces[next(std::size(pieces))];
    try {
      const YamlDocument document = YamlDocument::from_text(text);
      ++documents;
    } catch (const ConfigError& error) {  // any other exception ends the test
      CHECK(std::string(error.what()).size() <= dynfilter::Error::kMaxBytes);
    }
  }
  CHECK(documents > 500);
  CHECK(documents < 45000);
}

TEST_CASE("keys that nobody asks for may repeat") {
  const auto document = YamlDocument::from_text("Camera.fps: 30\nmine.a: 1\nCamera.fps: 30\nmine.b: 2\n");
  CHECK(document.root().find("mine.b")->integer() == 2);
  CHECK(document.root().entries("mine.").size() == 2);
  CHECK_THROWS_WITH_AS(document.root().entries(), "key `Camera.fps` is written twice", ConfigError);
  CHECK_THROWS_WITH_AS(document.root().find("Camera.fps"), "key `Camera.fps` is written twice", ConfigError);
}

TEST_CASE("a text of 100,000 keys is refused, the most keys that fit are read in time") {
  const auto taken = [](const std::string& text, std::string& error) {
    return dynfilter_test::seconds([&] {
      error = error_of(text, [](const dynfilter::YamlNode& root) {
        root.entries();
        root.find("k0");
      });
    });
  };
  const auto keys = [](std::size_t n, std::size_t most_bytes) {
    std::string text;
    for (std::size_t k = 0; k < n; ++k) {
      const std::string line = "k" + std::to_string(k) + ": 1\n";
      if (text.size() + line.size() > most_bytes) break;
      text += line;
    }
    return text;
  };
  std::string error;
  CHECK(taken(keys(100'000, std::string::npos), error) < dynfilter_test::kMost_s);
  CHECK(error == "file.yaml: not valid YAML: expected at most 256 kB");
  CHECK(taken(keys(100'000, dynfilter::YamlText::kMaxBytes), error) < dynfilter_test::kMost_s);
  CHECK(error == "no error");
}

}  // namespace yaml_test
