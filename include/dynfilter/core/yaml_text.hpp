// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <dynfilter/core/error.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace dynfilter {

/// A value of a YAML text as written. The reader interprets plain text.
struct YamlValue {
  enum class Kind { Plain, Quoted, Map, List };
  using Children = std::vector<std::pair<std::string, YamlValue>>;

  YamlValue() = default;  // an aggregate would not compile with Clang as C++20

  Kind kind = Kind::Plain;
  std::string text;   ///< of Plain and Quoted values
  Children children;  ///< in text order; keys are empty in a list and may repeat in a map
};

/// Reads the part of YAML that settings files use, in time linear in the text length.
/// Accepts maps and lists by indentation or in brackets, plain and quoted values on one line,
/// comments, and tags, which are ignored.
/// Also accepts two OpenCV extensions: `%YAML:1.0` and `key:value`.
/// Everything else is an error that names the line.
/// Examples are anchors, block scalars (`|`, `>`), keys without a value,
/// a second document and control bytes.
class YamlText {
 public:
  /// Settings files have a few kilobytes.
  /// The shortest value takes two bytes of text and 100 bytes of memory.
  /// This limit keeps a document below about 25 MB of memory.
  static constexpr std::size_t kMaxBytes = 256 * 1024;
  /// Pipelines nest 8 levels deep. One level uses less than 2 kB of stack, even with sanitizers.
  static constexpr int kMaxDepth = 64;

  /// The root is a map or a list; an empty text gives an empty map. Throws ConfigError.
  static YamlValue read(const std::string& text) { return YamlText(text).document(); }

 private:
  explicit YamlText(const std::string& text) : text_(text) {}

  // ---- characters
  [[noreturn]] void fail(const std::string& what) const { fail_at(line_, what); }
  [[noreturn]] static void fail_at(int line, const std::string& what) {
    throw ConfigError("", "not valid YAML: line " + std::to_string(line) + ", " + what);
  }

  bool at_end() const { return at_ >= end_; }
  char here(std::size_t ahead = 0) const { return at_ + ahead < end_ ? text_[at_ + ahead] : '\n'; }
  static bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }
  bool blank_or_end(std::size_t ahead) const { return is_blank(here(ahead)) || here(ahead) == '\n'; }
  std::size_t column() const { return at_ - line_start_; }
  bool at_comment() const { return here() == '#' && (column() == 0 || is_blank(text_[at_ - 1])); }

  void skip_blanks() {
    while (is_blank(here())) ++at_;
    if (at_comment())
      while (here() != '\n') ++at_;
  }
  void next_line() {
    ++at_;
    ++line_;
    line_start_ = at_;
  }
  bool starts_with(const char* word) const { return text_.compare(at_, 3, word) == 0; }
  bool at_marker() const {
    return column() == 0 && !at_end() && (starts_with("---") || starts_with("...")) && blank_or_end(3);
  }
  void skip_rest_of_line() {
    skip_blanks();
    if (here() != '\n') fail("unexpected text after the value");
  }

  void check_bytes() const {
    if (text_.size() > kMaxBytes)
      throw ConfigError("", "not valid YAML: expected at most " + std::to_string(kMaxBytes / 1024) + " kB");
    int line = 1;
    for (const char c : text_) {
      const auto byte = static_cast<unsigned char>(c);
      if (c == '\n') ++line;
      if ((byte < 32 && c != '\n' && c != '\t' && c != '\r') || byte == 127)
        fail_at(line, "a control byte (" + std::to_string(byte) + ")");
    }
  }

  // ---- the document
  YamlValue document() {
    check_bytes();
    end_ = text_.size();
    if (text_.compare(0, 3, "\xEF\xBB\xBF") == 0) at_ = line_start_ = 3;
    skip_head();
    YamlValue root;
    root.kind = YamlValue::Kind::Map;
    if (at_end()) return root;
    root = at_list_item() ? list(column(), 1) : map(column(), 1);
    if (!at_end()) fail("unexpected indentation");
    return root;
  }

  /// Skips directives and one `---`.
  void skip_head() {
    bool marked = false;
    for (;; next_line()) {
      skip_blanks();
      if (at_end()) return;
      if (here() == '%' && column() == 0 && !marked) {
        while (here() != '\n') ++at_;
      } else if (at_marker() && starts_with("---") && !marked) {
        marked = true;
        at_ += 3;
        skip_rest_of_line();
      } else if (here() != '\n') {
        break;
      }
    }
    to_content();
  }

  /// Advances to the next character that is neither blank nor part of a comment,
  /// at most to the end of the document.
  void to_content() {
    for (;; next_line()) {
      if (at_marker()) return end_document();
      skip_blanks();
      if (at_end()) return;
      if (here() != '\n') break;
    }
    const std::string_view before(text_.data() + line_start_, column());
    if (before.find_first_not_of(" \t\r") == std::string_view::npos &&
        before.find('\t') != std::string_view::npos)
      fail("a tab in the indentation");
  }
  void end_document() {
    if (starts_with("---")) fail("a second document");
    at_ += 3;
    skip_rest_of_line();
    for (; !at_end(); next_line()) {
      skip_blanks();
      if (!at_end() && here() != '\n') fail("text after the end of the document");
    }
  }

  // ---- by indentation
  bool at_list_item() const { return here() == '-' && blank_or_end(1); }

  void check_depth(int depth) const {
    if (depth > kMaxDepth) fail("nested more than " + std::to_string(kMaxDepth) + " deep");
  }

  /// Reads a block of lines with equal indentation, or a value of one line.
  YamlValue block(int depth) {
    check_depth(depth);
    if (at_list_item()) return list(column(), depth);
    if (here() != '[' && here() != '{' && at_key()) return map(column(), depth);
    return line_value(depth);
  }

  YamlValue map(std::size_t indent, int depth) {
    YamlValue result;
    result.kind = YamlValue::Kind::Map;
    do {
      std::string key = take_key();
      result.children.emplace_back(std::move(key), value_of_key(indent, depth));
    } while (same_indent(indent));
    return result;
  }
  YamlValue value_of_key(std::size_t indent, int depth) {
    skip_blanks();
    skip_tag();
    if (here() != '\n') return line_value(depth + 1);
    const int line = line_;
    to_content();
    const bool inside = !at_end() && (column() > indent || (column() == indent && at_list_item()));
    if (!inside) fail_at(line, "expected a value after the key");
    return block(depth + 1);
  }

  YamlValue list(std::size_t indent, int depth) {
    YamlValue result;
    result.kind = YamlValue::Kind::List;
    do {
      const int line = line_;
      ++at_;
      skip_blanks();
      skip_tag();
      if (here() == '\n') to_content();
      if (at_end() || column() <= indent) fail_at(line, "expected a value after `-`");
      result.children.emplace_back("", block(depth + 1));
    } while (same_indent(indent) && at_list_item());
    return result;
  }

  /// True if the current line belongs to the block with this indentation.
  bool same_indent(std::size_t indent) const {
    if (at_end() || column() < indent) return false;
    if (column() > indent) fail("unexpected indentation");
    return true;
  }

  /// True if this line has a `:` that ends a key.
  bool at_key() const {
    if (here() == '"' || here() == '\'') {
      std::size_t i = 1;
      while (here(i) != here() && here(i) != '\n') ++i;
      return here(i) == here() && here(i + 1) == ':';
    }
    for (std::size_t i = 0; here(i) != '\n'; ++i) {
      if (here(i) == '#' && i > 0 && is_blank(here(i - 1))) return false;
      if (here(i) == ':' && blank_or_end(i + 1)) return true;
    }
    return false;
  }
  /// Reads a key and its `:`.
  std::string take_key() {
    std::string key;
    if (here() == '"' || here() == '\'') {
      key = quoted();
      skip_blanks();
    } else {
      if (here() == '-' || here() == '?') fail("a key may not begin with `" + std::string(1, here()) + "`");
      const std::size_t from = at_;
      while (here() != ':' && here() != '\n' && !at_comment() && here() != ',' && here() != '}') ++at_;
      key = trimmed(from);
    }
    if (here() != ':') fail("expected `key: value`");
    if (key.empty()) fail("an empty key");
    ++at_;
    return key;
  }

  /// Reads a value of one line, or a value in brackets.
  YamlValue line_value(int depth) {
    YamlValue value = bracket_or_quote_or(depth, [&] {
      const std::size_t from = at_;
      while (here() != '\n' && !at_comment()) {
        if (here() == ':' && blank_or_end(1)) fail("a value with `: ` in it needs quotes");
        ++at_;
      }
      return trimmed(from);
    });
    skip_rest_of_line();
    to_content();
    return value;
  }

  // ---- in brackets
  template <class Plain>
  YamlValue bracket_or_quote_or(int depth, const Plain& plain) {
    skip_tag();
    if (at_list_item()) fail("a list begins in a line of its own, or in brackets");
    const char c = here();
    if (c == '[' || c == '{') return brackets(depth);
    YamlValue value;
    if (c == '"' || c == '\'') {
      value.kind = YamlValue::Kind::Quoted;
      value.text = quoted();
      return value;
    }
    static constexpr std::string_view kNotSupported = "&*|>?@`%";
    if (kNotSupported.find(c) != std::string_view::npos)
      fail(std::string("a value that begins with `") + c + "` needs quotes");
    value.text = plain();
    if (value.text.empty()) fail("expected a value");
    return value;
  }

  YamlValue brackets(int depth) {
    check_depth(depth);
    const int line = line_;
    const bool is_map = here() == '{';
    const char closing = is_map ? '}' : ']';
    YamlValue result;
    result.kind = is_map ? YamlValue::Kind::Map : YamlValue::Kind::List;
    ++at_;
    for (;;) {
      skip_lines(line);
      if (here() == closing) break;
      std::string key = is_map ? take_key() : "";
      skip_lines(line);
      result.children.emplace_back(std::move(key), flow_value(depth + 1));
      skip_lines(line);
      if (here() == ',')
        ++at_;
      else if (here() != closing)
        fail(std::string("expected `,` or `") + closing + "`");
    }
    ++at_;
    return result;
  }
  void skip_lines(int opened) {
    for (;; next_line()) {
      skip_blanks();
      if (at_end()) fail_at(opened, "a bracket that is not closed");
      if (here() != '\n') return;
    }
  }
  YamlValue flow_value(int depth) {
    return bracket_or_quote_or(depth, [&] {
      const std::size_t from = at_;
      static constexpr std::string_view kEnds = ",[]{}\n";
      while (kEnds.find(here()) == std::string_view::npos && !at_comment()) {
        if (here() == ':' && blank_or_end(1)) fail("a value with `: ` in it needs quotes");
        ++at_;
      }
      return trimmed(from);
    });
  }

  // ---- one value
  std::string trimmed(std::size_t from) const {
    std::size_t to = at_;
    while (to > from && is_blank(text_[to - 1])) --to;
    return text_.substr(from, to - from);
  }
  /// Skips a tag such as `!!opencv-matrix` or `!!str`. The reader of the value checks its type.
  void skip_tag() {
    if (here() != '!') return;
    while (!blank_or_end(0) && here() != ',') ++at_;
    skip_blanks();
  }
  std::string quoted() {
    const char quote = here();
    std::string value;
    for (++at_;; ++at_) {
      if (here() == '\n') fail("a quote that is not closed in its line");
      if (here() == quote && quote == '\'' && here(1) == '\'')
        ++at_;
      else if (here() == quote)
        break;
      value += quote == '"' && here() == '\\' ? escaped() : here();
    }
    ++at_;
    return value;
  }
  char escaped() {
    ++at_;
    switch (here()) {
      case 'n':
        return '\n';
      case 't':
        return '\t';
      case 'r':
        return '\r';
      case '"':
      case '\\':
      case '\'':
      case '/':
        return here();
      default:
        fail("an unknown escape: expected \\n, \\t, \\r, \\\", \\\\ or \\/");
    }
  }

  const std::string& text_;
  std::size_t at_ = 0, end_ = 0, line_start_ = 0;
  int line_ = 1;
};

}  // namespace dynfilter
