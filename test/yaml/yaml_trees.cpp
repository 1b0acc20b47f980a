// SPDX-License-Identifier: MIT
// Reads documents from stdin, each as `BYTES\n` and its bytes, and prints what YamlText makes of each in a
// line of JSON:
//   {"error": "..."}, or a tree of {"map": [[KEY, TREE], ...]}, {"list": [TREE, ...]}, {"quoted": TEXT} and
//   {"plain": TEXT} with "number", "integer", "flag" and "word" for the readers of YamlNode that accept it.
#include <dynfilter/config/numbers.hpp>
#include <dynfilter/config/yaml.hpp>
#include <dynfilter/config/yaml_text.hpp>
#include <dynfilter/core/error.hpp>
#include <iostream>
#include <string>

namespace {

using dynfilter::YamlNode;
using dynfilter::YamlValue;

std::string json(const std::string& text) {
  static const char* const kHex = "0123456789abcdef";
  std::string result = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\')
      result += '\\', result += c;
    else if (byte < 32)
      result += "\\u00", result += kHex[byte >> 4U], result += kHex[byte & 15U];
    else
      result += c;
  }
  return result + "\"";
}

template <class Read>
std::string reading(const char* name, const Read& read) {
  try {
    return std::string(", \"") + name + "\": " + read();
  } catch (const dynfilter::ConfigError&) {
    return "";
  }
}

std::string readings(const YamlValue& value) {
  const YamlNode node(value, "");
  constexpr int kEveryDigit = 17;
  return reading("number", [&] { return dynfilter::number_text(node.real(), kEveryDigit); }) +
         reading("integer", [&] { return std::to_string(node.integer()); }) +
         reading("flag", [&] { return node.flag() ? "true" : "false"; }) +
         reading("word", [&] { return json(node.text()); });
}

std::string tree(const YamlValue& value) {
  if (value.kind == YamlValue::Kind::Quoted)
    return "{\"quoted\": " + json(value.text) + readings(value) + "}";
  if (value.kind == YamlValue::Kind::Plain) return "{\"plain\": " + json(value.text) + readings(value) + "}";
  const bool is_map = value.kind == YamlValue::Kind::Map;
  std::string children;
  for (const auto& [key, child] : value.children) {
    if (!children.empty()) children += ", ";
    children += is_map ? "[" + json(key) + ", " + tree(child) + "]" : tree(child);
  }
  return (is_map ? "{\"map\": [" : "{\"list\": [") + children + "]}";
}

std::string read(const std::string& text) {
  try {
    return tree(dynfilter::YamlText::read(text));
  } catch (const dynfilter::ConfigError& error) {
    return "{\"error\": " + json(error.what()) + "}";
  }
}

}  // namespace

int main() {
  std::ios::sync_with_stdio(false);
  for (std::string line; std::getline(std::cin, line);) {
    std::string text(std::stoul(line), '\0');
    std::cin.read(text.data(), static_cast<std::streamsize>(text.size()));
    std::cout << read(text) << '\n';
  }
}
