// SPDX-License-Identifier: MIT
#pragma once

#include <climits>
#include <cmath>
#include <dynfilter/core/error.hpp>
#include <fstream>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace dynfilter {

/// A strict view of OpenCV's YAML, and the only code that touches cv::FileNode. OpenCV reads `flag: false` as
/// true, "abc" as 1.8e308, 3.7 as 4, a missing key as 0 and the first of two equal keys: here each of these
/// throws ConfigError with the path of the node and what was expected.
class YamlNode {
 public:
  YamlNode() = default;
  YamlNode(const cv::FileNode& node, std::string path) : node_(node), path_(std::move(path)) {}

  const std::string& path() const { return path_; }
  bool is_map() const { return node_.isMap(); }
  bool is_sequence() const { return node_.isSeq(); }
  bool is_text() const { return node_.isString(); }
  bool is_none() const { return node_.empty() || node_.isNone(); }

  [[noreturn]] void fail(const std::string& message) const { throw ConfigError(path_, message); }

  /// Keys and values in the order of the file. Throws on a key that is written twice.
  std::vector<std::pair<std::string, YamlNode>> entries() const {
    if (is_none()) return {};
    if (!is_map()) fail("expected `key: value` pairs, got " + shown());
    std::vector<std::pair<std::string, YamlNode>> result;
    for (const auto& child : node_) {
      const std::string key = child.name();
      for (const auto& [known, value] : result)
        if (known == key) fail("key `" + key + "` is written twice");
      result.emplace_back(key, YamlNode(child, child_path(key)));
    }
    return result;
  }
  std::vector<YamlNode> items() const {
    if (!is_sequence()) fail("expected a list, got " + shown());
    std::vector<YamlNode> result;
    std::size_t i = 0;
    for (auto it = node_.begin(); it != node_.end(); ++it, ++i)
      result.emplace_back(*it, path_ + "[" + std::to_string(i) + "]");
    return result;
  }
  std::optional<YamlNode> find(const std::string& key) const {
    for (auto& [name, value] : entries())
      if (name == key) return value;
    return std::nullopt;
  }

  double real() const {
    if (node_.isInt()) return static_cast<int>(node_);
    if (!node_.isReal()) fail("expected a number, got " + shown());
    const auto value = static_cast<double>(node_);
    if (!std::isfinite(value)) fail("expected a finite number, got " + shown());
    return value;
  }
  int integer() const {
    if (!node_.isInt()) fail("expected a whole number, got " + shown());
    return static_cast<int>(node_);
  }
  bool flag() const {
    if (node_.isString()) {
      const std::string word = text();
      if (word == "true") return true;
      if (word == "false") return false;
    } else if (node_.isInt()) {
      const int value = static_cast<int>(node_);
      if (value == 0 || value == 1) return value == 1;
    }
    fail("expected true or false, got " + shown());
  }
  /// OpenCV keeps a trailing comment as part of an unquoted text: it is cut here.
  std::string text() const {
    if (!node_.isString()) fail("expected a word, got " + shown());
    std::string value = node_.string();
    const auto comment = value.find(" #");
    if (comment != std::string::npos) value.erase(comment);
    while (!value.empty() && (value.back() == ' ' || value.back() == '\t')) value.pop_back();
    return value;
  }
  std::vector<std::string> texts() const {
    std::vector<std::string> result;
    if (is_sequence())
      for (const YamlNode& item : items()) result.push_back(item.text());
    else
      result.push_back(text());
    return result;
  }

  /// A list of numbers; a single number is a list of one.
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

  /// The node as an error message shows it.
  std::string shown() const {
    if (is_none()) return "nothing";
    if (is_map()) return "a map";
    if (is_sequence()) return "a list";
    if (is_text()) return "`" + node_.string() + "`";
    std::ostringstream out;
    out << '`' << (node_.isInt() ? static_cast<double>(static_cast<int>(node_)) : static_cast<double>(node_))
        << '`';
    return out.str();
  }

 private:
  std::string child_path(const std::string& key) const { return path_.empty() ? key : path_ + "." + key; }

  cv::FileNode node_;
  std::string path_;
};

/// A parsed YAML text. Nodes are valid as long as the document lives.
class YamlDocument {
 public:
  /// Throws ConfigError naming `source` and, for a syntax error, the line.
  static YamlDocument from_text(std::string text, const std::string& source = "") {
    if (text.rfind("%YAML", 0) != 0) text.insert(0, "%YAML:1.0\n---\n");
    YamlDocument document;
    document.source_ = source;
    try {
      document.storage_ = std::make_shared<cv::FileStorage>(
          text, cv::FileStorage::READ | cv::FileStorage::FORMAT_YAML | cv::FileStorage::MEMORY);
    } catch (const cv::Exception& error) {
      throw ConfigError(source, "not valid YAML: " + message_of(error));
    }
    if (!document.storage_->isOpened()) throw ConfigError(source, "not valid YAML");
    if (!document.root().is_map()) throw ConfigError(source, "expected `key: value` pairs, found none");
    return document;
  }
  static YamlDocument from_file(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    std::ostringstream text;
    if (!file || !(text << file.rdbuf())) throw ConfigError(path, "cannot be read");
    return from_text(text.str(), path);
  }

  YamlNode root() const { return {storage_->root(), ""}; }
  const std::string& source() const { return source_; }

 private:
  static std::string message_of(const cv::Exception& error) {
    // OpenCV names the line as "(21): Incorrect indentation" inside the text it calls the function's name.
    const std::string text = error.what();
    const auto from = text.rfind("'(");
    const auto to = text.rfind('\'');
    if (from == std::string::npos || to <= from) return "a syntax error";
    std::string found = text.substr(from + 2, to - from - 2);
    const auto bracket = found.find("): ");
    return bracket == std::string::npos
               ? found
               : "line " + found.substr(0, bracket) + ", " + found.substr(bracket + 3);
  }

  std::shared_ptr<cv::FileStorage> storage_;
  std::string source_;
};

}  // namespace dynfilter
