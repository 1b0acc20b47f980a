// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <dynfilter/core/error.hpp>
#include <dynfilter/core/field_table.hpp>
#include <dynfilter/core/yaml.hpp>
#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace dynfilter {

/// What `dynfilter filters NAME` and the tables in the docs print about a parameter.
struct FieldInfo {
  std::string name, type, unit, default_value, range, doc;
};

/// One parameter of a plain struct P: name, member, unit, range and meaning.
/// The YAML reader, the range check, the cards and the docs all use the table `P::fields()`.
template <class P>
struct Field {
  FieldInfo info;  ///< describe() fills default_value
  std::function<void(P&, const YamlNode&)> read;
  std::function<std::string(const P&)> print;
  std::function<void(const P&, const std::string& path)>
      check;  ///< throws ConfigError if the value is out of range
};

template <class T>
struct Range {
  T min, max;
};

namespace detail {

std::string shown(double value);

std::string joined(const std::vector<std::string>& words);

std::string range_text(double min, double max);

template <class T>
std::string shown_list(const std::vector<T>& values) {
  std::vector<std::string> words;
  for (const T value : values) words.push_back(shown(static_cast<double>(value)));
  return "[" + joined(words) + "]";
}

/// Checks each entry of a list against the range.
template <class P, class T>
std::function<void(const P&, const std::string&)> each_in_range(std::vector<T> P::*member, Range<T> range) {
  return [=](const P& p, const std::string& path) {
    for (const T value : p.*member)
      if (!(value >= range.min && value <= range.max))
        throw ConfigError(path,
                          "expected " + range_text(range.min, range.max) + ", got `" + shown(value) + "`");
  };
}

template <class P, class T>
std::function<void(const P&, const std::string&)> range_check(T P::*member, Range<T> range) {
  return [=](const P& p, const std::string& path) {
    if (!(p.*member >= range.min && p.*member <= range.max))
      throw ConfigError(path,
                        "expected " + range_text(range.min, range.max) + ", got `" + shown(p.*member) + "`");
  };
}

}  // namespace detail

/// A number in a range, both ends included. `unit` and `doc` are for display.
/// The functions below do the same for other types.
template <class P>
Field<P> real(const char* name, double P::*member, const char* unit, Range<double> range, const char* doc) {
  return {{name, "number", unit, "", detail::range_text(range.min, range.max), doc},
          [=](P& p, const YamlNode& node) { p.*member = node.real(); },
          [=](const P& p) { return detail::shown(p.*member); },
          detail::range_check(member, range)};
}

template <class P>
Field<P> integer(const char* name, int P::*member, const char* unit, Range<int> range, const char* doc) {
  return {{name, "integer", unit, "", detail::range_text(range.min, range.max), doc},
          [=](P& p, const YamlNode& node) { p.*member = node.integer(); },
          [=](const P& p) { return std::to_string(p.*member); },
          detail::range_check(member, range)};
}

template <class P>
Field<P> flag(const char* name, bool P::*member, const char* doc) {
  return {{name, "flag", "", "", "true, false", doc},
          [=](P& p, const YamlNode& node) { p.*member = node.flag(); },
          [=](const P& p) { return std::string(p.*member ? "true" : "false"); },
          [](const P&, const std::string&) {}};
}

template <class P>
Field<P> text(const char* name, std::string P::*member, const char* doc) {
  return {{name, "text", "", "", "", doc},
          [=](P& p, const YamlNode& node) { p.*member = node.text(); },
          [=](const P& p) { return p.*member; },
          [](const P&, const std::string&) {}};
}

template <class P>
Field<P> words(const char* name, std::vector<std::string> P::*member, const char* doc) {
  return {{name, "list of words", "", "", "", doc},
          [=](P& p, const YamlNode& node) { p.*member = node.texts(); },
          [=](const P& p) { return "[" + detail::joined(p.*member) + "]"; },
          [](const P&, const std::string&) {}};
}

template <class P>
Field<P> reals(const char* name, std::vector<double> P::*member, const char* unit, Range<double> range,
               const char* doc) {
  return {{name, "list of numbers", unit, "", detail::range_text(range.min, range.max), doc},
          [=](P& p, const YamlNode& node) { p.*member = node.reals(); },
          [=](const P& p) { return detail::shown_list(p.*member); },
          detail::each_in_range(member, range)};
}

template <class P>
Field<P> integers(const char* name, std::vector<int> P::*member, Range<int> range, const char* doc) {
  return {{name, "list of integers", "", "", detail::range_text(range.min, range.max), doc},
          [=](P& p, const YamlNode& node) { p.*member = node.integers(); },
          [=](const P& p) { return detail::shown_list(p.*member); },
          detail::each_in_range(member, range)};
}

/// A word that selects one value of an enumeration.
template <class P, class E>
Field<P> choice(const char* name, E P::*member, std::vector<std::pair<std::string, E>> values,
                const char* doc) {
  std::vector<std::string> names;
  for (const auto& value : values) names.push_back(value.first);
  const std::string known = detail::joined(names);
  return {{name, "choice", "", "", known, doc},
          [=](P& p, const YamlNode& node) {
            const std::string word = node.text();
            for (const auto& [text, value] : values)
              if (text == word) {
                p.*member = value;
                return;
              }
            node.fail("expected one of " + known + ", got `" + word + "`");
          },
          [=](const P& p) {
            for (const auto& [text, value] : values)
              if (value == p.*member) return text;
            return std::string("?");
          },
          [](const P&, const std::string&) {}};
}

template <class P>
void check_parameters(const P& p, const std::string& path = "");
template <class P>
P read_parameters(const YamlNode& node, P p = P(), const std::vector<std::string>& other_keys = {});

/// A nested map with its own parameters.
template <class P, class S>
Field<P> group(const char* name, S P::*member, const char* doc) {
  return {{name, "map", "", "", "", doc},
          [=](P& p, const YamlNode& node) { p.*member = read_parameters<S>(node, p.*member); },
          [](const P&) { return std::string("its own defaults"); },
          [=](const P& p, const std::string& path) { check_parameters(p.*member, path); }};
}

/// Adds the parameters of a member struct to P's own.
template <class P, class S>
void include_fields(FieldTable<P>& table, S P::*member) {
  for (const Field<S>& field : S::fields())
    table.push_back({field.info, [=](P& p, const YamlNode& node) { field.read(p.*member, node); },
                     [=](const P& p) { return field.print(p.*member); },
                     [=](const P& p, const std::string& path) { field.check(p.*member, path); }});
}

/// Throws ConfigError naming the first parameter that is out of range.
template <class P>
void check_parameters(const P& p, const std::string& path) {
  for (const Field<P>& field : P::fields())
    field.check(p, path.empty() ? field.info.name : path + "." + field.info.name);
}

/// Overwrites `p` with the values of the node.
/// Throws ConfigError for unknown keys, wrong types and values out of range.
/// Keys in `other_keys` are accepted and left to the caller.
template <class P>
P read_parameters(const YamlNode& node, P p, const std::vector<std::string>& other_keys) {
  const FieldTable<P>& table = P::fields();
  for (const auto& [key, value] : node.entries()) {
    if (std::find(other_keys.begin(), other_keys.end(), key) != other_keys.end()) continue;
    const Field<P>* field = nullptr;
    for (const Field<P>& candidate : table)
      if (candidate.info.name == key) field = &candidate;
    if (field == nullptr) {
      std::vector<std::string> known = other_keys;
      for (const Field<P>& candidate : table) known.push_back(candidate.info.name);
      node.fail("unknown key `" + key + "`; known keys: " + (known.empty() ? "none" : detail::joined(known)));
    }
    field->read(p, value);
    field->check(p, value.path());
  }
  return p;
}

/// The parameter table with default values, for display.
template <class P>
std::vector<FieldInfo> describe_parameters(const P& defaults = P()) {
  std::vector<FieldInfo> infos;
  for (const Field<P>& field : P::fields()) {
    infos.push_back(field.info);
    infos.back().default_value = field.print(defaults);
  }
  return infos;
}

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/core/detail/parameters-inl.hpp>
#endif
