// SPDX-License-Identifier: MIT
#pragma once

#include <climits>
#include <cmath>
#include <dynfilter/core/error.hpp>
#include <dynfilter/core/numbers.hpp>
#include <dynfilter/core/yaml_text.hpp>
#include <fstream>
#include <ios>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace dynfilter {

/// A strict view of one value of a YAML text.
/// A wrong type, a number out of range or a duplicate key throws ConfigError
/// with the path of the node and the expected type.
class YamlNode {
 public:
  /// A node for a path without a value.
  explicit YamlNode(std::string path = "") : path_(std::move(path)) {}
  YamlNode(const YamlValue& value, std::string path) : value_(&value), path_(std::move(path)) {}

  const std::string& path() const { return path_; }
  bool is_map() const { return is(YamlValue::Kind::Map); }
  bool is_sequence() const { return is(YamlValue::Kind::List); }
  bool is_text() const { return is(YamlValue::Kind::Quoted) || (is(YamlValue::Kind::Plain) && !is_number()); }
  bool is_none() const { return value_ == nullptr; }

  [[noreturn]] void fail(const std::string& message) const { throw ConfigError(path_, message); }

  /// All keys in file order, duplicates included.
  std::vector<std::string> keys() const {
    std::vector<std::string> result;
    if (is_map())
      for (const auto& child : value_->children) result.push_back(child.first);
    return result;
  }
  /// Keys that begin with `prefix` and their values, in file order.
  /// Throws if one of these keys is duplicated.
  std::vector<std::pair<std::string, YamlNode>> entries(const std::string& prefix = "") const {
    if (is_none()) return {};
    if (!is_map()) fail("expected `key: value` pairs, got " + shown());
    std::vector<std::pair<std::string, YamlNode>> result;
    std::set<std::string> known;
    for (const auto& [key, value] : value_->children) {
      if (key.rfind(prefix, 0) != 0) continue;
      if (!known.insert(key).second) fail("key `" + key + "` is written twice");
      result.emplace_back(key, YamlNode(value, child_path(key)));
    }
    return result;
  }
  std::vector<YamlNode> items() const {
    if (!is_sequence()) fail("expected a list, got " + shown());
    std::vector<YamlNode> result;
    for (const auto& child : value_->children)
      result.emplace_back(child.second, path_ + "[" + std::to_string(result.size()) + "]");
    return result;
  }
  /// Throws if this key is duplicated. Other keys are not checked.
  std::optional<YamlNode> find(const std::string& key) const {
    if (is_none()) return std::nullopt;
    if (!is_map()) fail("expected `key: value` pairs, got " + shown());
    std::optional<YamlNode> found;
    for (const auto& [name, value] : value_->children) {
      if (name != key) continue;
      if (found) fail("key `" + key + "` is written twice");
      found.emplace(value, child_path(key));
    }
    return found;
  }

  double real() const {
    if (!is_number()) fail("expected a number, got " + shown());
    const std::optional<double> value = parse_number(value_->text);
    if (!value || !std::isfinite(*value)) fail("expected a finite number, got " + shown());
    return *value;
  }
  int integer() const {
    if (!is_number() || value_->text.find_first_not_of("+-0123456789") != std::string::npos)
      fail("expected a whole number, got " + shown());
    const std::optional<double> value = parse_number(value_->text);
    if (!value || *value < INT_MIN || *value > INT_MAX)
      fail("expected a whole number of 32 bits, got " + shown());
    return static_cast<int>(*value);
  }
  bool flag() const {
    if (is_text() || is_number()) {
      const std::string& word = value_->text;
      if (word == "true" || word == "1") return true;
      if (word == "false" || word == "0") return false;
    }
    fail("expected true or false, got " + shown());
  }
  std::string text() const {
    if (!is_text()) fail("expected a word, got " + shown());
    return value_->text;
  }
  std::vector<std::string> texts() const {
    std::vector<std::string> result;
    if (is_sequence())
      for (const YamlNode& item : items()) result.push_back(item.text());
    else
      result.push_back(text());
    return result;
  }

  /// A list of numbers. A single number is read as a list of one.
  std::vector<double> reals() const {
    std::vector<double> result;
    if (!is_sequence()) return {real()};
    for (const YamlNode& item : items()) result.push_back(item.real());
    return result;
  }
  std::vector<int> integers() const {
    std::vector<int> result;
    if (!is_sequence()) return {integer()};
    for (const YamlNode& item : items()) result.push_back(item.integer());
    return result;
  }

  /// The node as error messages print it.
  std::string shown() const {
    if (is_none()) return "nothing";
    if (is_map()) return "a map";
    if (is_sequence()) return "a list";
    return "`" + value_->text + "`";
  }

 private:
  bool is(YamlValue::Kind kind) const { return value_ != nullptr && value_->kind == kind; }
  /// True for a number without quotes.
  /// 010 is rejected because some readers take it as 8 and others as 10.
  bool is_number() const {
    if (!is(YamlValue::Kind::Plain)) return false;
    const std::string& text = value_->text;
    const std::size_t first = text.find_first_not_of("+-");
    if (first == std::string::npos) return false;
    const bool leading_zero =
        text[first] == '0' && first + 1 < text.size() && detail::is_digit(text[first + 1]);
    return (detail::has_number_syntax(text) && !leading_zero) || text.substr(first) == ".inf" ||
           text == ".nan";
  }
  std::string child_path(const std::string& key) const { return path_.empty() ? key : path_ + "." + key; }

  const YamlValue* value_ = nullptr;
  std::string path_;
};

/// A parsed YAML text. Its nodes are valid while the document exists.
class YamlDocument {
 public:
  /// Throws ConfigError naming `source` and, for a syntax error, the line.
  static YamlDocument from_text(const std::string& text, const std::string& source = "") {
    YamlDocument document;
    document.source_ = source;
    try {
      document.root_ = std::make_shared<const YamlValue>(YamlText::read(text));
    } catch (const ConfigError& error) {
      throw ConfigError(source, error.what());
    }
    if (!document.root().is_map() || document.root_->children.empty())
      throw ConfigError(source, "expected `key: value` pairs, found none");
    return document;
  }
  static YamlDocument from_file(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    // One extra byte detects a file that is too long.
    std::string text(YamlText::kMaxBytes + 1, '\0');
    file.read(text.data(), static_cast<std::streamsize>(text.size()));
    if (file.bad() || (file.fail() && !file.eof())) throw ConfigError(path, "cannot be read");
    text.resize(static_cast<std::size_t>(file.gcount()));
    return from_text(text, path);
  }

  YamlNode root() const { return {*root_, ""}; }
  const std::string& source() const { return source_; }

 private:
  std::shared_ptr<const YamlValue> root_;
  std::string source_;
};

}  // namespace dynfilter
