// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/yaml.hpp>

#include <cmath>
#include <cstddef>
#include <dynfilter/core/inline.hpp>
#include <dynfilter/core/numbers.hpp>
#include <dynfilter/core/yaml_text.hpp>
#include <fstream>
#include <ios>
#include <set>

namespace dynfilter {

namespace detail {
inline bool is_kind(const YamlValue* value, YamlValue::Kind kind) {
  return value != nullptr && value->kind == kind;
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
         (detail::is_kind(value_, YamlValue::Kind::Plain) && !is_number());
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
    if (!known.insert(key).second) fail("key `" + key + "` is written twice");
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
    if (found) fail("key `" + key + "` is written twice");
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
  if (is_text() || is_number()) {
    const std::string& word = value_->text;
    if (word == "true" || word == "1") return true;
    if (word == "false" || word == "0") return false;
  }
  fail("expected true or false, got " + shown());
}

DYNFILTER_INLINE std::string YamlNode::text() const {
  if (!is_text()) fail("expected a word, got " + shown());
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
  return "`" + value_->text + "`";
}

DYNFILTER_INLINE bool YamlNode::is_number() const {
  if (!detail::is_kind(value_, YamlValue::Kind::Plain)) return false;
  const std::string& text = value_->text;
  const std::size_t first = text.find_first_not_of("+-");
  if (first == std::string::npos) return false;
  const bool leading_zero =
      text[first] == '0' && first + 1 < text.size() && detail::is_digit(text[first + 1]);
  return (detail::has_number_syntax(text) && !leading_zero) || text.substr(first) == ".inf" || text == ".nan";
}

inline std::string YamlNode::child_path(const std::string& key) const {
  return path_.empty() ? key : path_ + "." + key;
}

DYNFILTER_INLINE YamlDocument YamlDocument::from_text(const std::string& text, const std::string& source) {
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
