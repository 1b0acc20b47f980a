// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <dynfilter/core/error.hpp>
#include <string>
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
/// What it accepts has the meaning that YAML 1.1 (PyYAML) gives it; the rest is an error with line and column.
/// Accepts maps and lists by indentation or in brackets, plain and quoted values on one line, and comments.
/// Errors are anchors, aliases, merge keys, tags, block texts (`|`, `>`), texts over several lines,
/// keys without a value, a second document, control characters and Unicode line breaks.
/// Line breaks are LF, CR LF and CR.
///
/// Accepts more than PyYAML, as OpenCV's own files need it:
/// - `%YAML:1.0` as the first line, and no `---` after it;
/// - `key:value` without a blank, if the key has only letters, digits, `_`, `.` and `-` and begins with no
///   digit, no other `:` in its line has a blank after it, and no brackets are around it;
/// - tags `!!opencv-...` before a map, which are ignored;
/// - tabs between values, though not in the indentation;
/// - `\'` in double quotes;
/// - comments of any encoding.
class YamlText {
 public:
  /// Settings files have a few kilobytes.
  /// The shortest value takes two bytes of text and 100 bytes of memory.
  /// This limit keeps a document below about 25 MB of memory.
  static constexpr std::size_t kMaxBytes = 256 * 1024;
  /// Pipelines nest 8 levels deep. One level uses less than 2 kB of stack, even with sanitizers.
  static constexpr int kMaxDepth = 64;
  /// A key's length in YAML 1.1, with its quotes and the blanks before `:`.
  static constexpr std::size_t kMaxKeyBytes = 1024;

  /// The root is a map or a list; an empty text gives an empty map. Throws ConfigError.
  static YamlValue read(const std::string& text);

 private:
  explicit YamlText(std::string text) : text_(std::move(text)) {}

  /// Both from 1. Columns are characters, not bytes.
  struct Place {
    int line = 1, column = 1;
  };

  // ---- characters
  [[noreturn]] void fail(const std::string& what) const { fail_at(place(at_), what); }
  [[noreturn]] static void fail_at(Place place, const std::string& what);
  /// Of a byte in the current line.
  Place place(std::size_t at) const;

  bool at_end() const { return at_ >= end_; }
  char here(std::size_t ahead = 0) const { return at_ + ahead < end_ ? text_[at_ + ahead] : '\n'; }
  static bool is_blank(char c) { return c == ' ' || c == '\t'; }
  bool blank_or_end(std::size_t ahead) const { return is_blank(here(ahead)) || here(ahead) == '\n'; }
  bool at_quote() const { return here() == '"' || here() == '\''; }
  std::size_t column() const { return at_ - line_start_; }
  bool at_comment() const { return here() == '#' && (column() == 0 || is_blank(text_[at_ - 1])); }
  bool tab_before() const;

  void skip_blanks();
  void next_line();
  bool starts_with(const char* word) const { return text_.compare(at_, 3, word) == 0; }
  bool at_marker() const {
    return column() == 0 && !at_end() && (starts_with("---") || starts_with("...")) && blank_or_end(3);
  }
  void skip_rest_of_line();

  /// Control characters and Unicode line breaks, comments included.
  void check_bytes();

  // ---- the document
  YamlValue document();

  /// Skips `%YAML` and one `---`.
  void skip_head();
  void skip_version();

  /// Advances to the next character that is neither blank nor part of a comment,
  /// at most to the end of the document.
  void to_content();
  void end_document();

  // ---- by indentation
  bool at_list_item() const { return here() == '-' && blank_or_end(1); }

  void check_depth(int depth) const;

  /// Reads a block of lines with equal indentation, or a value of one line.
  YamlValue block(int depth);

  YamlValue map(std::size_t indent, int depth);
  YamlValue value_of_key(std::size_t indent, int depth);

  YamlValue list(std::size_t indent, int depth);

  /// A value that begins in one of the next lines, or after `- `.
  YamlValue block_after_tag(bool tagged, int depth);

  /// True if the current line belongs to the block with this indentation.
  bool same_indent(std::size_t indent) const;

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

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/config/detail/yaml_text-inl.hpp>
#endif
