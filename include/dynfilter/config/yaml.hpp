// SPDX-License-Identifier: MIT
#pragma once

#include <climits>
#include <dynfilter/core/error.hpp>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace dynfilter {

struct YamlValue;  // yaml_text.hpp

/// A strict view of one value of a YAML text. A wrong type, a number out of range or a duplicate key throws
/// ConfigError with the path of the node and the expected type. A plain value is a number, a flag or a word
/// if the reader expects one and YAML 1.1 agrees, with two exceptions:
/// - `1e5` and `-.5` are numbers, as in OpenCV and JSON. YAML 1.1 takes them for words.
/// - `true`, `yes`, `on` and their like are words where a word is expected, and keys are always words.
class YamlNode {
 public:
  /// A node for a path without a value.
  explicit YamlNode(std::string path = "") : path_(std::move(path)) {}
  /// `value` is not copied; `path` is its place, for messages.
  YamlNode(const YamlValue& value, std::string path) : value_(&value), path_(std::move(path)) {}

  const std::string& path() const { return path_; }          ///< its place, e.g. `pipeline.floor`
  bool is_map() const;                                       ///< whether it is a map
  bool is_sequence() const;                                  ///< whether it is a list
  bool is_text() const;                                      ///< whether it is a single value
  bool is_none() const { return value_ == nullptr; }         ///< whether there is no value at its path
  [[noreturn]] void fail(const std::string& message) const;  ///< throws ConfigError with the path

  std::vector<std::string> keys() const;  ///< all keys in file order, duplicates included
  /// Keys that begin with `prefix` and their values, in file order.
  /// Throws if one of these keys is duplicated.
  std::vector<std::pair<std::string, YamlNode>> entries(const std::string& prefix = "") const;
  std::vector<YamlNode> items() const;  ///< the members of a list; throws ConfigError for anything else
  std::optional<YamlNode> find(const std::string& key) const;  ///< throws if this key is duplicated

  double real() const;  ///< a finite number; throws ConfigError for anything else
  int integer() const;  ///< throws ConfigError for fractions and for what an int cannot hold
  bool flag() const;    ///< true, false, 1 or 0, without quotes
  /// A quoted text, or a plain one that YAML 1.1 takes for no number, date or null.
  std::string text() const;
  std::vector<std::string> texts() const;  ///< a list of texts; a single text is a list of one

  /// A list of numbers. A single number is read as a list of one.
  std::vector<double> reals() const;
  std::vector<int> integers() const;  ///< like reals(), for integers

  std::string shown() const;  ///< the node as error messages print it

 private:
  /// True for a decimal number without quotes.
  /// 010 is rejected because some readers take it as 8 and others as 10.
  bool is_number() const;
  std::string child_path(const std::string& key) const;

  const YamlValue* value_ = nullptr;
  std::string path_;
};

/// A parsed YAML text. Its nodes are valid while the document exists.
class YamlDocument {
 public:
  /// Throws ConfigError naming `source` and, for a syntax error, the line.
  static YamlDocument from_text(const std::string& text, const std::string& source = "");
  static YamlDocument from_file(const std::string& path);  ///< throws ConfigError

  YamlNode root() const { return {*root_, ""}; }         ///< the value at the top
  const std::string& source() const { return source_; }  ///< the file's path, or what from_text() got
  const std::string& text() const { return text_; }      ///< what was parsed

 private:
  std::shared_ptr<const YamlValue> root_;
  std::string source_, text_;
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/config/detail/yaml-inl.hpp>
#endif
