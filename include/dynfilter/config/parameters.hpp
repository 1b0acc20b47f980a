// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <dynfilter/config/field_table.hpp>
#include <dynfilter/config/yaml.hpp>
#include <initializer_list>
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

enum class FieldKind { Real, Integer, Flag, Text, Words, Reals, Integers, Choice, Group };

struct AnyField;
using AnyFields = std::vector<AnyField>;

/// A parameter of any struct, at `offset` bytes from the struct's start. `p` is the struct. Literals and
/// numbers only, because every struct's table is code in each file that has it.
struct AnyField {
  FieldKind kind;
  const char *name, *unit, *doc;
  std::size_t offset;
  double min = 0, max = 0;                ///< of a number
  const AnyFields& (*group)() = nullptr;  ///< of a nested map
  /// Words, and the enumerators as numbers, up to the first null.
  static constexpr std::size_t kMostChoices = 8;
  std::pair<const char*, int> choices[kMostChoices] = {};

  /// Throws ConfigError for a wrong type and for a value out of range.
  void read(void* p, const YamlNode& node) const;
  void check(const void* p, const std::string& path) const;
  std::string print(const void* p) const;
  FieldInfo info(const void* defaults) const;
};

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

/// One parameter of a plain struct P: name, member, unit, range and meaning. Texts are literals.
/// The YAML reader, the range check, the cards and the docs all use the table `P::fields()`.
template <class P>
struct Field : detail::AnyField {
  explicit Field(const detail::AnyField& field) : detail::AnyField(field) {}
};

/// The parameters of a plain struct P.
template <class P>
class FieldTable {
 public:
  FieldTable() = default;
  /// In the order in which cards and pages list them.
  FieldTable(std::initializer_list<Field<P>> fields) : all_(fields.begin(), fields.end()) {}
  /// Appends one, after those of the table.
  void push_back(const Field<P>& field) { all_.push_back(field); }
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
  return Field<P>(
      {detail::FieldKind::Real, name, unit, doc, detail::offset_of(member), range.min, range.max});
}
template <class P>
Field<P> integer(const char* name, int P::*member, const char* unit, Range<int> range, const char* doc) {
  return Field<P>({detail::FieldKind::Integer, name, unit, doc, detail::offset_of(member),
                   static_cast<double>(range.min), static_cast<double>(range.max)});
}
template <class P>
Field<P> flag(const char* name, bool P::*member, const char* doc) {
  return Field<P>({detail::FieldKind::Flag, name, "", doc, detail::offset_of(member)});
}
template <class P>
Field<P> text(const char* name, std::string P::*member, const char* doc) {
  return Field<P>({detail::FieldKind::Text, name, "", doc, detail::offset_of(member)});
}
template <class P>
Field<P> words(const char* name, std::vector<std::string> P::*member, const char* doc) {
  return Field<P>({detail::FieldKind::Words, name, "", doc, detail::offset_of(member)});
}
template <class P>
Field<P> reals(const char* name, std::vector<double> P::*member, const char* unit, Range<double> range,
               const char* doc) {
  return Field<P>(
      {detail::FieldKind::Reals, name, unit, doc, detail::offset_of(member), range.min, range.max});
}
template <class P>
Field<P> integers(const char* name, std::vector<int> P::*member, Range<int> range, const char* doc) {
  return Field<P>({detail::FieldKind::Integers, name, "", doc, detail::offset_of(member),
                   static_cast<double>(range.min), static_cast<double>(range.max)});
}

/// A word that selects one value of an enumeration, and its value.
template <class E>
struct Choice {
  const char* word;
  E value;
};

/// One of several words.
template <class P, class E, std::size_t kCount>
Field<P> choice(const char* name, E P::*member, const Choice<E> (&choices)[kCount], const char* doc) {
  static_assert(std::is_same<std::underlying_type_t<E>, int>::value, "an enumeration of int");
  static_assert(kCount <= detail::AnyField::kMostChoices, "more words than a field has room for");
  detail::AnyField field{detail::FieldKind::Choice, name, "", doc, detail::offset_of(member)};
  for (std::size_t k = 0; k < kCount; ++k)
    field.choices[k] = {choices[k].word, static_cast<int>(choices[k].value)};
  return Field<P>(field);
}

/// A nested map with its own parameters.
template <class P, class S>
Field<P> group(const char* name, S P::*member, const char* doc) {
  detail::AnyField field{detail::FieldKind::Group, name, "", doc, detail::offset_of(member)};
  field.group = []() -> const detail::AnyFields& { return S::fields().all(); };
  return Field<P>(field);
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
