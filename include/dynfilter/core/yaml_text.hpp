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
  [[noreturn]] static void fail_at(int line, const std::string& what);

  bool at_end() const { return at_ >= end_; }
  char here(std::size_t ahead = 0) const { return at_ + ahead < end_ ? text_[at_ + ahead] : '\n'; }
  static bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }
  bool blank_or_end(std::size_t ahead) const { return is_blank(here(ahead)) || here(ahead) == '\n'; }
  std::size_t column() const { return at_ - line_start_; }
  bool at_comment() const { return here() == '#' && (column() == 0 || is_blank(text_[at_ - 1])); }

  void skip_blanks();
  void next_line();
  bool starts_with(const char* word) const { return text_.compare(at_, 3, word) == 0; }
  bool at_marker() const {
    return column() == 0 && !at_end() && (starts_with("---") || starts_with("...")) && blank_or_end(3);
  }
  void skip_rest_of_line();

  void check_bytes() const;

  // ---- the document
  YamlValue document();

  /// Skips directives and one `---`.
  void skip_head();

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

  /// True if the current line belongs to the block with this indentation.
  bool same_indent(std::size_t indent) const;

  /// True if this line has a `:` that ends a key.
  bool at_key() const;
  /// Reads a key and its `:`.
  std::string take_key();

  /// Reads a value of one line, or a value in brackets.
  YamlValue line_value(int depth);

  // ---- in brackets
  template <class Plain>
  YamlValue bracket_or_quote_or(int depth, const Plain& plain);

  YamlValue brackets(int depth);
  void skip_lines(int opened);
  YamlValue flow_value(int depth);

  // ---- one value
  std::string trimmed(std::size_t from) const;
  /// Skips a tag such as `!!opencv-matrix` or `!!str`. The reader of the value checks its type.
  void skip_tag();
  std::string quoted();
  char escaped();

  const std::string& text_;
  std::size_t at_ = 0, end_ = 0, line_start_ = 0;
  int line_ = 1;
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/core/detail/yaml_text-inl.hpp>
#endif
