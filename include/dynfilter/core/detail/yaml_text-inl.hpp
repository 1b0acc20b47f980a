// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/yaml_text.hpp>

#include <dynfilter/core/inline.hpp>
#include <string_view>

namespace dynfilter {

DYNFILTER_INLINE void YamlText::fail_at(int line, const std::string& what) {
  throw ConfigError("", "not valid YAML: line " + std::to_string(line) + ", " + what);
}

inline void YamlText::skip_blanks() {
  while (is_blank(here())) ++at_;
  if (at_comment())
    while (here() != '\n') ++at_;
}

inline void YamlText::next_line() {
  ++at_;
  ++line_;
  line_start_ = at_;
}

inline void YamlText::skip_rest_of_line() {
  skip_blanks();
  if (here() != '\n') fail("unexpected text after the value");
}

inline void YamlText::check_bytes() const {
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

DYNFILTER_INLINE YamlValue YamlText::document() {
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

inline void YamlText::skip_head() {
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

inline void YamlText::to_content() {
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

inline void YamlText::end_document() {
  if (starts_with("---")) fail("a second document");
  at_ += 3;
  skip_rest_of_line();
  for (; !at_end(); next_line()) {
    skip_blanks();
    if (!at_end() && here() != '\n') fail("text after the end of the document");
  }
}

inline void YamlText::check_depth(int depth) const {
  if (depth > kMaxDepth) fail("nested more than " + std::to_string(kMaxDepth) + " deep");
}

inline YamlValue YamlText::block(int depth) {
  check_depth(depth);
  if (at_list_item()) return list(column(), depth);
  if (here() != '[' && here() != '{' && at_key()) return map(column(), depth);
  return line_value(depth);
}

inline YamlValue YamlText::map(std::size_t indent, int depth) {
  YamlValue result;
  result.kind = YamlValue::Kind::Map;
  do {
    std::string key = take_key();
    result.children.emplace_back(std::move(key), value_of_key(indent, depth));
  } while (same_indent(indent));
  return result;
}

inline YamlValue YamlText::value_of_key(std::size_t indent, int depth) {
  skip_blanks();
  skip_tag();
  if (here() != '\n') return line_value(depth + 1);
  const int line = line_;
  to_content();
  const bool inside = !at_end() && (column() > indent || (column() == indent && at_list_item()));
  if (!inside) fail_at(line, "expected a value after the key");
  return block(depth + 1);
}

inline YamlValue YamlText::list(std::size_t indent, int depth) {
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

inline bool YamlText::same_indent(std::size_t indent) const {
  if (at_end() || column() < indent) return false;
  if (column() > indent) fail("unexpected indentation");
  return true;
}

inline bool YamlText::at_key() const {
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

inline std::string YamlText::take_key() {
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

inline YamlValue YamlText::line_value(int depth) {
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

template <class Plain>
YamlValue YamlText::bracket_or_quote_or(int depth, const Plain& plain) {
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

inline YamlValue YamlText::brackets(int depth) {
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

inline void YamlText::skip_lines(int opened) {
  for (;; next_line()) {
    skip_blanks();
    if (at_end()) fail_at(opened, "a bracket that is not closed");
    if (here() != '\n') return;
  }
}

inline YamlValue YamlText::flow_value(int depth) {
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

inline std::string YamlText::trimmed(std::size_t from) const {
  std::size_t to = at_;
  while (to > from && is_blank(text_[to - 1])) --to;
  return text_.substr(from, to - from);
}

inline void YamlText::skip_tag() {
  if (here() != '!') return;
  while (!blank_or_end(0) && here() != ',') ++at_;
  skip_blanks();
}

inline std::string YamlText::quoted() {
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

inline char YamlText::escaped() {
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

}  // namespace dynfilter
