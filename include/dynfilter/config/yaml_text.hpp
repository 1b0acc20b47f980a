// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <dynfilter/core/error.hpp>
#include <dynfilter/core/printable_text.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace dynfilter {

/// A value of a YAML text as written. The reader interprets plain text.
struct YamlValue {
  /// Plain or quoted text, a map, or a list.
  enum class Kind { Plain, Quoted, Map, List };
  using Children = std::vector<std::pair<std::string, YamlValue>>;

  YamlValue() = default;  // an aggregate would not compile with Clang as C++20

  Kind kind = Kind::Plain;
  std::string text;   ///< of Plain and Quoted values
  Children children;  ///< in text order; keys are empty in a list and may repeat in a map
};

namespace detail {

/// YAML has three line breaks of one byte or two, and the parser one.
inline std::string with_lf_only(const std::string& text) {
  std::string result;
  result.reserve(text.size());
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool before_lf = i + 1 < text.size() && text[i + 1] == '\n';
    if (text[i] != '\r')
      result += text[i];
    else if (!before_lf)
      result += '\n';
  }
  return result;
}

/// As OpenCV writes keys.
inline bool is_settings_key(std::string_view key) {
  const bool begins_with_digit = !key.empty() && key[0] >= '0' && key[0] <= '9';
  return !begins_with_digit && std::all_of(key.begin(), key.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
           c == '.' || c == '-';
  });
}

}  // namespace detail

/// Reads the part of YAML that settings files use, in time linear in the text length. What it accepts has the
/// meaning that YAML 1.1 (PyYAML) gives it; the rest is an error with line and column. Accepts maps and lists
/// by indentation or in brackets, plain and quoted values on one line, and comments. Errors are anchors,
/// aliases, merge keys, tags, block texts (`|`, `>`) and texts over several lines. So are keys without a
/// value, a second document, control characters and Unicode line breaks. Line breaks are LF, CR LF and CR.
///
/// Accepts more than PyYAML, as OpenCV's own files need it:
/// - `%YAML:1.0` as the first line, and no `---` after it;
/// - `key:value` without a blank, if the key has only letters, digits, `_`, `.` and `-` and begins with no
///   digit, no other `:` in its line has a blank after it, and no brackets are around it;
/// - tags `!!opencv-...` before a map, which are ignored;
/// - tabs between values, though not in the indentation, `\'` in double quotes, comments of any encoding.
class YamlText {
 public:
  /// Settings files have a few kilobytes. The shortest value takes two bytes of text and 100 bytes of memory.
  /// This limit keeps a document below about 25 MB of memory.
  static constexpr std::size_t kMaxBytes = 256 * 1024;
  /// Pipelines nest 8 levels deep. One level uses less than 2 kB of stack, even with sanitizers.
  static constexpr int kMaxDepth = 64;
  /// A key's length in YAML 1.1, with its quotes and the blanks before `:`.
  static constexpr std::size_t kMaxKeyBytes = 1024;

  /// The root is a map or a list; an empty text gives an empty map. Throws ConfigError.
  static YamlValue read(const std::string& text) {
    if (text.size() > kMaxBytes)
      throw ConfigError("", "not valid YAML: expected at most " + std::to_string(kMaxBytes / 1024) + " kB");
    return YamlText(detail::with_lf_only(text)).document();
  }

 private:
  explicit YamlText(std::string text) : text_(std::move(text)) {}

  /// Both from 1. Columns are characters, not bytes.
  struct Place {
    int line = 1, column = 1;
  };

  // ---- characters
  [[noreturn]] void fail(const std::string& what) const { fail_at(place(at_), what); }
  [[noreturn]] static void fail_at(Place place, const std::string& what) {
    throw ConfigError("", "not valid YAML: line " + std::to_string(place.line) + ", column " +
                              std::to_string(place.column) + ": " + what);
  }
  /// Of a byte in the current line.
  Place place(std::size_t at) const;

  bool at_end() const { return at_ >= end_; }
  char here(std::size_t ahead = 0) const { return at_ + ahead < end_ ? text_[at_ + ahead] : '\n'; }
  static bool is_blank(char c) { return c == ' ' || c == '\t'; }
  bool blank_or_end(std::size_t ahead) const { return is_blank(here(ahead)) || here(ahead) == '\n'; }
  bool at_quote() const { return here() == '"' || here() == '\''; }
  std::size_t column() const { return at_ - line_start_; }
  bool at_comment() const { return here() == '#' && (column() == 0 || is_blank(text_[at_ - 1])); }
  bool tab_before() const {
    return std::string_view(text_.data() + line_start_, column()).find('\t') != std::string_view::npos;
  }
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

  /// Control characters and Unicode line breaks, comments included.
  void check_bytes();

  // ---- the document
  YamlValue document();

  /// Skips `%YAML` and one `---`.
  void skip_head();
  void skip_version();

  /// Advances to the next character that is neither blank nor part of a comment, at most to the end.
  void to_content();
  void end_document();

  // ---- by indentation
  bool at_list_item() const { return here() == '-' && blank_or_end(1); }

  void check_depth(int depth) const {
    if (depth > kMaxDepth) fail("nested more than " + std::to_string(kMaxDepth) + " deep");
  }

  /// Reads a block of lines with equal indentation, or a value of one line.
  YamlValue block(int depth);

  YamlValue map(std::size_t indent, int depth);
  YamlValue value_of_key(std::size_t indent, int depth);
  YamlValue list(std::size_t indent, int depth);

  /// A value that begins in one of the next lines, or after `- `.
  YamlValue block_after_tag(bool tagged, int depth);

  /// True if the current line belongs to the block with this indentation.
  bool same_indent(std::size_t indent) const {
    if (at_end() || column() < indent) return false;
    if (column() > indent) fail("unexpected indentation");
    return true;
  }

  /// True if this line has a `:` and a blank that end a key.
  bool at_key() const;
  bool has_spaced_colon(std::size_t from) const;
  /// Reads a key and its `:`.
  std::string take_key(bool in_brackets);
  /// Fails if no blank follows the `:` here, except after a key of a settings file that begins at `from`.
  void check_colon(std::size_t from, bool in_brackets) const;

  /// Reads a value of one line, or a value in brackets.
  YamlValue line_value(int depth);

  // ---- in brackets
  template <class Plain>
  YamlValue bracket_or_quote_or(int depth, const Plain& plain);
  YamlValue brackets(int depth);
  void skip_lines(Place opened);
  YamlValue flow_value(int depth);
  static bool is_bracket_or_comma(char c) { return c == ',' || c == '[' || c == ']' || c == '{' || c == '}'; }

  // ---- one value
  /// `what`: "a key" or "a value". Fails at a character with which no plain text begins.
  void check_start(const char* what) const;
  /// From there to here without blanks at the end. Fails at a character that is not printable.
  std::string taken(std::size_t from) const;
  void check_text(std::size_t from, std::size_t to) const;
  /// Skips a tag such as `!!opencv-matrix`. True if there was one: a map must follow.
  bool skip_tag();
  std::string quoted();
  /// The byte after the quote that closes the text here; npos if none does in this line.
  std::size_t after_quote() const;
  char escaped();

  std::string text_;  ///< with LF as the only line break
  std::size_t at_ = 0, end_ = 0, line_start_ = 0;
  int line_ = 1;
};

inline YamlText::Place YamlText::place(std::size_t at) const {
  Place result{line_, 1};
  for (std::size_t i = line_start_; i < at && i < text_.size(); ++i)
    if (!is_utf8_continuation(text_[i])) ++result.column;
  return result;
}

inline void YamlText::check_bytes() {
  const auto begins = [&](const char* character) {
    return text_.compare(at_, std::char_traits<char>::length(character), character) == 0;
  };
  for (at_ = 0; at_ < text_.size();) {
    const auto byte = static_cast<unsigned char>(here());
    if ((byte < 32 && byte != '\n' && byte != '\t') || byte == 127)
      fail("a control byte (" + std::to_string(byte) + ")");
    if (begins("\xC2\x85") || begins("\xE2\x80\xA8") || begins("\xE2\x80\xA9"))
      fail("a line break that most editors do not show (U+0085, U+2028 or U+2029)");
    if (at_ > 0 && begins("\xEF\xBB\xBF")) fail("a byte order mark inside the text");
    if (byte == '\n')
      next_line();
    else
      ++at_;
  }
  at_ = line_start_ = 0;
  line_ = 1;
}

inline YamlValue YamlText::document() {
  end_ = text_.size();
  check_bytes();
  if (text_.compare(0, 3, "\xEF\xBB\xBF") == 0) at_ = line_start_ = 3;
  skip_head();
  YamlValue root;
  root.kind = YamlValue::Kind::Map;
  if (at_end()) return root;
  if (at_list_item())
    root = list(column(), 1);
  else
    root = here() == '{' || here() == '[' ? line_value(1) : map(column(), 1);
  if (!at_end()) fail("unexpected indentation");
  return root;
}

inline void YamlText::skip_head() {
  bool marked = false, versioned = false;
  for (;; next_line()) {
    skip_blanks();
    if (at_end()) return;
    if (here() == '%' && column() == 0 && !marked && !versioned) {
      skip_version();
      versioned = true;
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

inline void YamlText::skip_version() {
  const auto at = [&](std::string_view word) { return text_.compare(at_, word.size(), word) == 0; };
  static constexpr std::string_view kYaml = "%YAML:1.", kSpaced = "%YAML 1.";
  if (!at(kYaml) && !at(kSpaced)) fail("a directive: expected `%YAML:1.0` or none");
  at_ += kYaml.size();
  if (here() < '0' || here() > '9') fail("expected `%YAML:1.0`");
  ++at_;
  skip_rest_of_line();
}

inline void YamlText::to_content() {
  for (;; next_line()) {
    if (at_marker()) return end_document();
    skip_blanks();
    if (at_end()) return;
    if (here() != '\n') break;
  }
  const std::string_view before(text_.data() + line_start_, column());
  if (before.find_first_not_of(" \t") == std::string_view::npos && tab_before())
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

inline YamlValue YamlText::block(int depth) {
  check_depth(depth);
  const bool is_list = at_list_item(), is_map = !is_list && here() != '[' && here() != '{' && at_key();
  if ((is_list || is_map) && tab_before()) fail("a tab in the indentation");
  if (is_list) return list(column(), depth);
  if (is_map) return map(column(), depth);
  return line_value(depth);
}

inline YamlValue YamlText::map(std::size_t indent, int depth) {
  YamlValue result;
  result.kind = YamlValue::Kind::Map;
  do {
    std::string key = take_key(false);
    result.children.emplace_back(std::move(key), value_of_key(indent, depth));
  } while (same_indent(indent));
  return result;
}

inline YamlValue YamlText::value_of_key(std::size_t indent, int depth) {
  skip_blanks();
  const Place after_key = place(at_);
  const bool tagged = skip_tag();
  if (here() != '\n') return line_value(depth + 1);
  to_content();
  const bool inside = !at_end() && (column() > indent || (column() == indent && at_list_item()));
  if (!inside) fail_at(after_key, "expected a value after the key");
  return block_after_tag(tagged, depth + 1);
}

inline YamlValue YamlText::list(std::size_t indent, int depth) {
  YamlValue result;
  result.kind = YamlValue::Kind::List;
  do {
    const Place dash = place(at_);
    ++at_;
    skip_blanks();
    const bool tagged = skip_tag();
    if (here() == '\n') to_content();
    if (at_end() || column() <= indent) fail_at(dash, "expected a value after `-`");
    result.children.emplace_back("", block_after_tag(tagged, depth + 1));
  } while (same_indent(indent) && at_list_item());
  return result;
}

inline YamlValue YamlText::block_after_tag(bool tagged, int depth) {
  const Place begin = place(at_);
  YamlValue value = block(depth);
  if (tagged && value.kind != YamlValue::Kind::Map) fail_at(begin, "expected a map after the tag");
  return value;
}

inline bool YamlText::at_key() const {
  if (at_quote()) {
    std::size_t i = after_quote();
    if (i == std::string::npos) return false;
    while (is_blank(here(i - at_))) ++i;
    return here(i - at_) == ':';
  }
  return has_spaced_colon(at_);
}

inline bool YamlText::has_spaced_colon(std::size_t from) const {
  const auto at = [&](std::size_t i) { return i < end_ ? text_[i] : '\n'; };
  for (std::size_t i = from; at(i) != '\n'; ++i) {
    if (at(i) == '#' && i > from && is_blank(at(i - 1))) return false;
    if (at(i) == ':' && (is_blank(at(i + 1)) || at(i + 1) == '\n')) return true;
  }
  return false;
}

inline std::string YamlText::take_key(bool in_brackets) {
  const std::size_t from = at_;
  const bool is_quoted = at_quote();
  std::string key;
  if (is_quoted) {
    key = quoted();
    skip_blanks();
  } else {
    if (here() == '-') fail("a key that begins with `-` needs quotes");
    if (here() != ':') check_start("a key");
    const auto ends = [&](char c) {
      return c == ':' || c == '\n' || (in_brackets && is_bracket_or_comma(c));
    };
    while (!ends(here()) && !at_comment()) {
      if (in_brackets && here() == '?') fail("a key with `?` in it needs quotes in brackets");
      ++at_;
    }
    key = taken(from);
  }
  if (here() != ':') fail("expected `key: value`");
  if (key.empty()) fail("an empty key");
  if (at_ - from > kMaxKeyBytes) fail("a key of more than " + std::to_string(kMaxKeyBytes) + " bytes");
  if (key == "<<" && !is_quoted) fail("a merge key (`<<`)");
  check_colon(from, in_brackets);
  ++at_;
  return key;
}

inline void YamlText::check_colon(std::size_t from, bool in_brackets) const {
  if (blank_or_end(1)) return;
  const std::string_view written(text_.data() + from, at_ - from);  // with its quotes
  const bool is_quoted = written.front() == '"' || written.front() == '\'';
  // YAML reads {a:1} as a key `a:1` without a value, and `a:b: 1` as a key `a:b`.
  const bool may_be_close =
      in_brackets ? is_quoted : detail::is_settings_key(written) && !has_spaced_colon(from);
  if (!may_be_close) fail("expected a blank after `:`");
}

inline YamlValue YamlText::line_value(int depth) {
  YamlValue value = bracket_or_quote_or(depth, [&] {
    const std::size_t from = at_;
    while (here() != '\n' && !at_comment()) {
      if (here() == ':' && blank_or_end(1)) fail("a value with `: ` in it needs quotes");
      ++at_;
    }
    return taken(from);
  });
  skip_rest_of_line();
  to_content();
  return value;
}

template <class Plain>
YamlValue YamlText::bracket_or_quote_or(int depth, const Plain& plain) {
  if (at_list_item()) fail("a list begins in a line of its own, or in brackets");
  if (here() == '[' || here() == '{') return brackets(depth);
  YamlValue value;
  if (at_quote()) {
    value.kind = YamlValue::Kind::Quoted;
    value.text = quoted();
    return value;
  }
  check_start("a value");
  value.text = plain();
  if (value.text.empty()) fail("expected a value");
  return value;
}

inline YamlValue YamlText::brackets(int depth) {
  check_depth(depth);
  const Place opened = place(at_);
  const bool is_map = here() == '{';
  const char closing = is_map ? '}' : ']';
  YamlValue result;
  result.kind = is_map ? YamlValue::Kind::Map : YamlValue::Kind::List;
  ++at_;
  for (;;) {
    skip_lines(opened);
    if (here() == closing) break;
    std::string key = is_map ? take_key(true) : "";
    skip_lines(opened);
    result.children.emplace_back(std::move(key), flow_value(depth + 1));
    skip_lines(opened);
    if (here() == ',')
      ++at_;
    else if (here() != closing)
      fail(std::string("expected `,` or `") + closing + "`");
  }
  ++at_;
  return result;
}

inline void YamlText::skip_lines(Place opened) {
  for (;; next_line()) {
    skip_blanks();
    if (at_end()) fail_at(opened, "a bracket that is not closed");
    if (at_marker()) fail("a document marker inside brackets");
    if (here() != '\n') return;
  }
}

inline YamlValue YamlText::flow_value(int depth) {
  skip_tag();
  return bracket_or_quote_or(depth, [&] {
    const std::size_t from = at_;
    while (!is_bracket_or_comma(here()) && here() != '\n' && !at_comment()) {
      const bool is_colon = here() == ':' && (blank_or_end(1) || is_bracket_or_comma(here(1)));
      if (is_colon || here() == '?')
        fail(std::string("a value with `") + here() + "` in it needs quotes in brackets");
      ++at_;
    }
    return taken(from);
  });
}

inline void YamlText::check_start(const char* what) const {
  // `-` begins a number or a word here: list items are read before.
  static constexpr std::string_view kIndicators = "?:,[]{}#&*!|>'\"%@`";
  if (kIndicators.find(here()) == std::string_view::npos) return;
  fail(std::string(what) + " that begins with `" + here() + "` needs quotes");
}

inline std::string YamlText::taken(std::size_t from) const {
  std::size_t to = at_;
  while (to > from && is_blank(text_[to - 1])) --to;
  check_text(from, to);
  return text_.substr(from, to - from);
}

inline void YamlText::check_text(std::size_t from, std::size_t to) const {
  const std::string_view text(text_.data() + from, to - from);
  for (std::size_t at = printable_utf8_bytes(text); at < text.size();
       at += 1 + printable_utf8_bytes(text.substr(at + 1)))
    if (!is_of_other_encoding(text.substr(at)))
      fail_at(place(from + at), "a character that is not printable");
}

inline bool YamlText::skip_tag() {
  if (here() != '!') return false;
  static constexpr std::string_view kOpenCv = "!!opencv-";
  const auto in_name = [](char c) { return (c >= 'a' && c <= 'z') || c == '-'; };
  if (text_.compare(at_, kOpenCv.size(), kOpenCv) != 0) fail("a tag: only `!!opencv-matrix` is known");
  while (in_name(here()) || here() == '!') ++at_;
  if (!blank_or_end(0)) fail("expected a blank after the tag");
  skip_blanks();
  if (here() != '{' && here() != '\n') fail("expected a map after the tag");
  return true;
}

inline std::size_t YamlText::after_quote() const {
  const char quote = here();
  for (std::size_t i = 1; here(i) != '\n'; ++i) {
    if (here(i) == '\\' && quote == '"') {
      ++i;
      if (here(i) == '\n') break;
    } else if (here(i) == quote && quote == '\'' && here(i + 1) == quote) {
      ++i;
    } else if (here(i) == quote) {
      return at_ + i + 1;
    }
  }
  return std::string::npos;
}

inline std::string YamlText::quoted() {
  const std::size_t after = after_quote();
  if (after == std::string::npos) fail("a quote that is not closed in its line");
  check_text(at_, after);
  const char quote = here();
  std::string value;
  for (++at_; at_ + 1 < after; ++at_) {
    if (quote == '\'' && here() == quote) ++at_;
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
