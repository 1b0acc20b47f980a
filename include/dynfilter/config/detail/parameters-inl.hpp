// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/config/parameters.hpp>

#include <algorithm>
#include <cstring>
#include <dynfilter/config/near_miss.hpp>
#include <dynfilter/config/numbers.hpp>
#include <dynfilter/core/error.hpp>
#include <dynfilter/core/inline.hpp>

namespace dynfilter {

namespace detail {

inline const char* type_name(FieldKind kind) {
  constexpr const char* kNames[] = {"number",          "integer",          "flag",   "text", "list of words",
                                    "list of numbers", "list of integers", "choice", "map"};
  return kNames[static_cast<std::size_t>(kind)];
}

inline std::vector<std::string> words_of(const AnyField& field) {
  std::vector<std::string> words;
  for (const auto& [word, number] : field.choices)
    if (word != nullptr) words.emplace_back(word);
  return words;
}

inline int chosen(const AnyField& field, const YamlNode& node) {
  const std::string text = node.text();
  for (const auto& [word, number] : field.choices)
    if (word != nullptr && text == word) return number;
  node.fail(expected_one_of(words_of(field), text));
}

inline std::string chosen_word(const AnyField& field, int value) {
  for (const auto& [word, number] : field.choices)
    if (word != nullptr && number == value) return word;
  return "?";
}

inline void check_range(const AnyField& field, double value, const std::string& path) {
  if (!(value >= field.min && value <= field.max))
    throw ConfigError(path,
                      "expected " + range_text(field.min, field.max) + ", got `" + number_text(value) + "`");
}

template <class T>
std::string shown_list(const std::vector<T>& values) {
  std::vector<std::string> words;
  for (const T value : values) words.push_back(number_text(static_cast<double>(value)));
  return "[" + joined(words) + "]";
}

DYNFILTER_INLINE void AnyField::read(void* p, const YamlNode& node) const {
  void* const value = static_cast<char*>(p) + offset;
  switch (kind) {
    case FieldKind::Real:
      *static_cast<double*>(value) = node.real();
      break;
    case FieldKind::Integer:
      *static_cast<int*>(value) = node.integer();
      break;
    case FieldKind::Flag:
      *static_cast<bool*>(value) = node.flag();
      break;
    case FieldKind::Text:
      *static_cast<std::string*>(value) = node.text();
      break;
    case FieldKind::Words:
      *static_cast<std::vector<std::string>*>(value) = node.texts();
      break;
    case FieldKind::Reals:
      *static_cast<std::vector<double>*>(value) = node.reals();
      break;
    case FieldKind::Integers:
      *static_cast<std::vector<int>*>(value) = node.integers();
      break;
    case FieldKind::Choice: {
      const int number = chosen(*this, node);
      std::memcpy(value, &number, sizeof number);
      break;
    }
    case FieldKind::Group:
      read_all(group(), node, value, {});
      break;
  }
  check(p, node.path());
}

DYNFILTER_INLINE void AnyField::check(const void* p, const std::string& path) const {
  const void* const value = static_cast<const char*>(p) + offset;
  switch (kind) {
    case FieldKind::Real:
      return check_range(*this, *static_cast<const double*>(value), path);
    case FieldKind::Integer:
      return check_range(*this, *static_cast<const int*>(value), path);
    case FieldKind::Reals:
      for (const double entry : *static_cast<const std::vector<double>*>(value))
        check_range(*this, entry, path);
      return;
    case FieldKind::Integers:
      for (const int entry : *static_cast<const std::vector<int>*>(value)) check_range(*this, entry, path);
      return;
    case FieldKind::Group:
      return check_all(group(), value, path);
    case FieldKind::Flag:
    case FieldKind::Text:
    case FieldKind::Words:
    case FieldKind::Choice:
      return;
  }
}

DYNFILTER_INLINE std::string AnyField::print(const void* p) const {
  const void* const value = static_cast<const char*>(p) + offset;
  switch (kind) {
    case FieldKind::Real:
      return number_text(*static_cast<const double*>(value));
    case FieldKind::Integer:
      return std::to_string(*static_cast<const int*>(value));
    case FieldKind::Flag:
      return *static_cast<const bool*>(value) ? "true" : "false";
    case FieldKind::Text:
      return *static_cast<const std::string*>(value);
    case FieldKind::Words:
      return "[" + joined(*static_cast<const std::vector<std::string>*>(value)) + "]";
    case FieldKind::Reals:
      return shown_list(*static_cast<const std::vector<double>*>(value));
    case FieldKind::Integers:
      return shown_list(*static_cast<const std::vector<int>*>(value));
    case FieldKind::Choice: {
      int number = 0;
      std::memcpy(&number, value, sizeof number);
      return chosen_word(*this, number);
    }
    case FieldKind::Group:
      return "its own defaults";
  }
  return "";
}

DYNFILTER_INLINE FieldInfo AnyField::info(const void* defaults) const {
  std::string range;
  if (kind == FieldKind::Flag) range = "true, false";
  if (kind == FieldKind::Choice) range = joined(words_of(*this));
  const bool number = kind == FieldKind::Real || kind == FieldKind::Integer || kind == FieldKind::Reals ||
                      kind == FieldKind::Integers;
  if (number) range = range_text(min, max);
  return {name, type_name(kind), unit, print(defaults), range, doc};
}

DYNFILTER_INLINE void include_all(AnyFields& table, const AnyFields& added, std::size_t offset) {
  for (AnyField field : added) {
    field.offset += offset;
    table.push_back(field);
  }
}

DYNFILTER_INLINE void check_all(const AnyFields& table, const void* p, const std::string& path) {
  for (const AnyField& field : table) field.check(p, path.empty() ? field.name : path + "." + field.name);
}

DYNFILTER_INLINE void read_all(const AnyFields& table, const YamlNode& node, void* p,
                               const std::vector<std::string>& other_keys) {
  for (const auto& [key, value] : node.entries()) {
    if (std::find(other_keys.begin(), other_keys.end(), key) != other_keys.end()) continue;
    const AnyField* field = nullptr;
    for (const AnyField& candidate : table)
      if (key == candidate.name) field = &candidate;
    if (field == nullptr) {
      std::vector<std::string> known = other_keys;
      for (const AnyField& candidate : table) known.emplace_back(candidate.name);
      node.fail(unknown_name("key", key, known));
    }
    field->read(p, value);
  }
}

DYNFILTER_INLINE std::vector<FieldInfo> describe_all(const AnyFields& table, const void* defaults) {
  std::vector<FieldInfo> infos;
  for (const AnyField& field : table) infos.push_back(field.info(defaults));
  return infos;
}

}  // namespace detail

}  // namespace dynfilter
