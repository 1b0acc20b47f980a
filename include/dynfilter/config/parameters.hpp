// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <dynfilter/config/field_table.hpp>
#include <dynfilter/config/yaml.hpp>
#include <initializer_list>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace dynfilter {

/// What `dynfilter filters NAME` and the tables in the docs print about a parameter.
struct FieldInfo {
  std::string name, type, unit, default_value, range, doc;
};

namespace detail {

class FieldType;  // how one type of parameter is read, printed and checked

/// A parameter of any struct, at `offset` bytes from the struct's start. `p` is the struct.
struct AnyField {
  FieldInfo info;  ///< describe_parameters() fills default_value
  std::size_t offset = 0;
  std::shared_ptr<const FieldType> type;

  /// Throws ConfigError for a wrong type and for a value out of range.
  void read(void* p, const YamlNode& node) const;
  void check(const void* p, const std::string& path) const;
  std::string print(const void* p) const;
};
using AnyFields = std::vector<AnyField>;

// One function for all structs and for each type of parameter.
AnyField real_field(const char* name, std::size_t offset, const char* unit, double min, double max,
                    const char* doc);
AnyField integer_field(const char* name, std::size_t offset, const char* unit, int min, int max,
                       const char* doc);
AnyField flag_field(const char* name, std::size_t offset, const char* doc);
AnyField text_field(const char* name, std::size_t offset, const char* doc);
AnyField words_field(const char* name, std::size_t offset, const char* doc);
AnyField reals_field(const char* name, std::size_t offset, const char* unit, double min, double max,
                     const char* doc);
AnyField integers_field(const char* name, std::size_t offset, int min, int max, const char* doc);
/// For an enumeration whose underlying type is int. `count` words and their values.
AnyField choice_field(const char* name, std::size_t offset, const char* const* words, const int* values,
                      std::size_t count, const char* doc);
AnyField group_field(const char* name, std::size_t offset, const AnyFields& (*fields)(), const char* doc);

void include_all(AnyFields& table, const AnyFields& added, std::size_t offset);
void check_all(const AnyFields& table, const void* p, const std::string& path);
void read_all(const AnyFields& table, const YamlNode& node, void* p,
              const std::vector<std::string>& other_keys);
std::vector<FieldInfo> describe_all(const AnyFields& table, const void* defaults);

template <class P, class T>
std::size_t offset_of(T P::*member) {
  static const P p{};
  return static_cast<std::size_t>(reinterpret_cast<const char*>(&(p.*member)) -
                                  reinterpret_cast<const char*>(&p));
}

}  // namespace detail

/// One parameter of a plain struct P: name, member, unit, range and meaning.
/// The YAML reader, the range check, the cards and the docs all use the table `P::fields()`.
template <class P>
struct Field : detail::AnyField {
  explicit Field(detail::AnyField field) : detail::AnyField(std::move(field)) {}
};

/// The parameters of a plain struct P.
template <class P>
class FieldTable {
 public:
  FieldTable() = default;
  /// In the order in which cards and pages list them.
  FieldTable(std::initializer_list<Field<P>> fields) : all_(fields.begin(), fields.end()) {}
  /// Appends one, after those of the table.
  void push_back(Field<P> field) { all_.push_back(std::move(field)); }
  const detail::AnyFields& all() const { return all_; }  ///< for readers of YAML and for cards
  detail::AnyFields& all() { return all_; }

 private:
  detail::AnyFields all_;
};

/// Smallest and largest value, both allowed.
template <class T>
struct Range {
  T min, max;
};

/// A number in a range, both ends included. `unit` and `doc` are for display.
/// The functions below do the same for other types.
template <class P>
Field<P> real(const char* name, double P::*member, const char* unit, Range<double> range, const char* doc) {
  return Field<P>(detail::real_field(name, detail::offset_of(member), unit, range.min, range.max, doc));
}
template <class P>
Field<P> integer(const char* name, int P::*member, const char* unit, Range<int> range, const char* doc) {
  return Field<P>(detail::integer_field(name, detail::offset_of(member), unit, range.min, range.max, doc));
}
template <class P>
Field<P> flag(const char* name, bool P::*member, const char* doc) {
  return Field<P>(detail::flag_field(name, detail::offset_of(member), doc));
}
template <class P>
Field<P> text(const char* name, std::string P::*member, const char* doc) {
  return Field<P>(detail::text_field(name, detail::offset_of(member), doc));
}
template <class P>
Field<P> words(const char* name, std::vector<std::string> P::*member, const char* doc) {
  return Field<P>(detail::words_field(name, detail::offset_of(member), doc));
}
template <class P>
Field<P> reals(const char* name, std::vector<double> P::*member, const char* unit, Range<double> range,
               const char* doc) {
  return Field<P>(detail::reals_field(name, detail::offset_of(member), unit, range.min, range.max, doc));
}
template <class P>
Field<P> integers(const char* name, std::vector<int> P::*member, Range<int> range, const char* doc) {
  return Field<P>(detail::integers_field(name, detail::offset_of(member), range.min, range.max, doc));
}

/// A word that selects one value of an enumeration, and its value.
template <class E>
struct Choice {
  const char* word;
  E value;
};

/// One of several words.
template <class P, class E>
Field<P> choice(const char* name, E P::*member, std::initializer_list<Choice<E>> choices, const char* doc) {
  static_assert(std::is_same<std::underlying_type_t<E>, int>::value, "an enumeration of int");
  std::vector<const char*> words;
  std::vector<int> values;
  for (const Choice<E>& c : choices) {
    words.push_back(c.word);
    values.push_back(static_cast<int>(c.value));
  }
  return Field<P>(
      detail::choice_field(name, detail::offset_of(member), words.data(), values.data(), words.size(), doc));
}

/// A nested map with its own parameters.
template <class P, class S>
Field<P> group(const char* name, S P::*member, const char* doc) {
  const auto fields = []() -> const detail::AnyFields& { return S::fields().all(); };
  return Field<P>(detail::group_field(name, detail::offset_of(member), fields, doc));
}

/// Adds the parameters of a member struct to P's own.
template <class P, class S>
void include_fields(FieldTable<P>& table, S P::*member) {
  detail::include_all(table.all(), S::fields().all(), detail::offset_of(member));
}

/// Throws ConfigError naming the first parameter that is out of range.
template <class P>
void check_parameters(const P& p, const std::string& path = "") {
  detail::check_all(P::fields().all(), &p, path);
}

/// Overwrites `p` with the values of the node. Throws ConfigError for unknown keys, wrong types and values
/// out of range. Keys in `other_keys` are accepted and left to the caller.
template <class P>
P read_parameters(const YamlNode& node, P p = P(), const std::vector<std::string>& other_keys = {}) {
  detail::read_all(P::fields().all(), node, &p, other_keys);
  return p;
}

/// The parameter table with default values, for display.
template <class P>
std::vector<FieldInfo> describe_parameters(const P& defaults = P()) {
  return detail::describe_all(P::fields().all(), &defaults);
}

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/config/detail/parameters-inl.hpp>
#endif
