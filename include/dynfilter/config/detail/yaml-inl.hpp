// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/config/yaml.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <dynfilter/config/numbers.hpp>
#include <dynfilter/config/yaml_text.hpp>
#include <dynfilter/core/inline.hpp>
#include <dynfilter/core/printable_text.hpp>
#include <fstream>
#include <initializer_list>
#include <ios>
#include <set>
#include <string_view>

namespace dynfilter {

namespace detail {
inline bool is_kind(const YamlValue* value, YamlValue::Kind kind) {
  return value != nullptr && value->kind == kind;
}

// Plain texts that YAML 1.1 resolves to something else than a word. Numbers that only it knows (010, 0x1F,
// 1_000, 1:30) are neither numbers nor words here, because readers differ.

inline std::string_view without_sign(std::string_view text) {
  if (!text.empty() && (text[0] == '+' || text[0] == '-')) text.remove_prefix(1);
  return text;
}

inline bool is_one_of(std::string_view text, std::initializer_list<std::string_view> words) {
  return std::find(words.begin(), words.end(), text) != words.end();
}

inline bool is_not_finite(std::string_view text) {
  return is_one_of(without_sign(text), {".inf", ".Inf", ".INF"}) || is_one_of(text, {".nan", ".NaN", ".NAN"});
}

inline bool has_only(std::string_view text, std::string_view allowed) {
  return text.find_first_not_of(allowed) == std::string_view::npos;
}

/// Digits with `_`, `:` or a point: octal numbers, grouped digits and base 60.
inline bool is_number_of_yaml(std::string_view text) {
  text = without_sign(text);
  const std::string_view prefix = text.substr(0, 2);
  if (prefix == "0x") return has_only(text.substr(2), "0123456789abcdefABCDEF_");
  if (prefix == "0b") return has_only(text.substr(2), "01_");
  const std::size_t exponent = text.find_first_of("eE");
  if (exponent != std::string_view::npos) {
    const std::string_view power = without_sign(text.substr(exponent + 1));
    if (power.empty() || !has_only(power, "0123456789")) return false;
  }
  const std::string_view digits = text.substr(0, exponent);
  const std::size_t first = digits.find_first_not_of('.');
  return first <= 1 && is_digit(digits[first]) && has_only(digits, "0123456789_:.") &&
         std::count(digits.begin(), digits.end(), '.') <= 1;
}

/// Begins with YYYY-M-D. What follows may be a time.
inline bool is_date(std::string_view text) {
  const auto digits = [&](std::size_t least, std::size_t most) {
    std::size_t n = 0;
    while (n < most && n < text.size() && is_digit(text[n])) ++n;
    text.remove_prefix(n);
    return n >= least;
  };
  const auto dash = [&] {
    if (text.empty() || text[0] != '-') return false;
    text.remove_prefix(1);
    return true;
  };
  return digits(4, 4) && dash() && digits(1, 2) && dash() && digits(1, 2) &&
         (text.empty() || is_one_of(text.substr(0, 1), {"T", "t", " ", "\t"}));
}

inline bool is_no_word(std::string_view text) {
  return is_one_of(text, {"~", "null", "Null", "NULL", "=", "<<"}) || has_number_syntax(text) ||
         is_not_finite(text) || is_number_of_yaml(text) || is_date(text);
}
}  // namespace detail

DYNFILTER_INLINE bool YamlNode::is_map() const {
  return detail::is_kind(value_, YamlValue::Kind::Map);
}
DYNFILTER_INLINE bool YamlNode::is_sequence() const {
  return detail::is_kind(value_, YamlValue::Kind::List);
}
DYNFILTER_INLINE bool YamlNode::is_text() const {
  return detail::is_kind(value_, YamlValue::Kind::Quoted) ||
         (detail::is_kind(value_, YamlValue::Kind::Plain) && !detail::is_no_word(value_->text));
}

DYNFILTER_INLINE void YamlNode::fail(const std::string& message) const {
  throw ConfigError(path_, message);
}

DYNFILTER_INLINE std::vector<std::string> YamlNode::keys() const {
  std::vector<std::string> result;
  if (is_map())
    for (const auto& child : value_->children) result.push_back(child.first);
  return result;
}

DYNFILTER_INLINE std::vector<std::pair<std::string, YamlNode>> YamlNode::entries(
    const std::string& prefix) const {
  if (is_none()) return {};
  if (!is_map()) fail("expected `key: value` pairs, got " + shown());
  std::vector<std::pair<std::string, YamlNode>> result;
  std::set<std::string> known;
  for (const auto& [key, value] : value_->children) {
    if (key.rfind(prefix, 0) != 0) continue;
    if (!known.insert(key).second) fail("key " + in_backticks(key) + " is written twice");
    result.emplace_back(key, YamlNode(value, child_path(key)));
  }
  return result;
}

DYNFILTER_INLINE std::vector<YamlNode> YamlNode::items() const {
  if (!is_sequence()) fail("expected a list, got " + shown());
  std::vector<YamlNode> result;
  for (const auto& child : value_->children)
    result.emplace_back(child.second, path_ + "[" + std::to_string(result.size()) + "]");
  return result;
}

DYNFILTER_INLINE std::optional<YamlNode> YamlNode::find(const std::string& key) const {
  if (is_none()) return std::nullopt;
  if (!is_map()) fail("expected `key: value` pairs, got " + shown());
  std::optional<YamlNode> found;
  for (const auto& [name, value] : value_->children) {
    if (name != key) continue;
    if (found) fail("key " + in_backticks(key) + " is written twice");
    found.emplace(value, child_path(key));
  }
  return found;
}

DYNFILTER_INLINE double YamlNode::real() const {
  if (!is_number()) fail("expected a number, got " + shown());
  const std::optional<double> value = parse_number(value_->text);
  if (!value || !std::isfinite(*value)) fail("expected a finite number, got " + shown());
  return *value;
}

DYNFILTER_INLINE int YamlNode::integer() const {
  if (!is_number() || value_->text.find_first_not_of("+-0123456789") != std::string::npos)
    fail("expected a whole number, got " + shown());
  const std::optional<double> value = parse_number(value_->text);
  if (!value || *value < INT_MIN || *value > INT_MAX)
    fail("expected a whole number of 32 bits, got " + shown());
  return static_cast<int>(*value);
}

DYNFILTER_INLINE bool YamlNode::flag() const {
  if (detail::is_kind(value_, YamlValue::Kind::Plain)) {
    const std::string& word = value_->text;
    if (word == "true" || word == "1") return true;
    if (word == "false" || word == "0") return false;
  }
  fail("expected true or false, got " + shown());
}

DYNFILTER_INLINE std::string YamlNode::text() const {
  if (!is_text()) {
    const bool is_plain = detail::is_kind(value_, YamlValue::Kind::Plain);
    fail("expected a word, got " + shown() + (is_plain ? ", which needs quotes as a word" : ""));
  }
  return value_->text;
}

DYNFILTER_INLINE std::vector<std::string> YamlNode::texts() const {
  std::vector<std::string> result;
  if (is_sequence())
    for (const YamlNode& item : items()) result.push_back(item.text());
  else
    result.push_back(text());
  return result;
}

DYNFILTER_INLINE std::vector<double> YamlNode::reals() const {
  std::vector<double> result;
  if (!is_sequence()) return {real()};
  for (const YamlNode& item : items()) result.push_back(item.real());
  return result;
}

DYNFILTER_INLINE std::vector<int> YamlNode::integers() const {
  std::vector<int> result;
  if (!is_sequence()) return {integer()};
  for (const YamlNode& item : items()) result.push_back(item.integer());
  return result;
}

DYNFILTER_INLINE std::string YamlNode::shown() const {
  if (is_none()) return "nothing";
  if (is_map()) return "a map";
  if (is_sequence()) return "a list";
  return in_backticks(value_->text);
}

DYNFILTER_INLINE bool YamlNode::is_number() const {
  if (!detail::is_kind(value_, YamlValue::Kind::Plain)) return false;
  const std::string_view text = detail::without_sign(value_->text);
  const bool leading_zero = text.size() > 1 && text[0] == '0' && detail::is_digit(text[1]);
  return (detail::has_number_syntax(value_->text) && !leading_zero) || detail::is_not_finite(value_->text);
}

inline std::string YamlNode::child_path(const std::string& key) const {
  const std::string name =
      printable_utf8_bytes(key) == key.size() && key.size() <= kMostQuotedColumns ? key : in_backticks(key);
  return path_.empty() ? name : path_ + "." + name;
}

DYNFILTER_INLINE YamlDocument YamlDocument::from_text(const std::string& text, const std::string& source) {
  YamlDocument document;
  document.source_ = source, document.text_ = text;
  try {
    document.root_ = std::make_shared<const YamlValue>(YamlText::read(text));
  } catch (const ConfigError& error) {
    throw ConfigError(source, error.what());
  }
  if (!document.root().is_map() || document.root_->children.empty())
    throw ConfigError(source, "expected `key: value` pairs, found none");
  return document;
}

DYNFILTER_INLINE YamlDocument YamlDocument::from_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  // One extra byte detects a file that is too long.
  std::string text(YamlText::kMaxBytes + 1, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (file.bad() || (file.fail() && !file.eof())) throw ConfigError(path, "cannot be read");
  text.resize(static_cast<std::size_t>(file.gcount()));
  return from_text(text, path);
}

}  // namespace dynfilter
