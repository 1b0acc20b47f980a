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

/// One type of parameter: how it is read, printed and checked, at the address of its value.
class FieldType {
 public:
  FieldType() = default;
  FieldType(const FieldType&) = delete;
  FieldType& operator=(const FieldType&) = delete;
  virtual ~FieldType() = default;
  virtual void read(void* value, const YamlNode& node) const = 0;
  virtual std::string print(const void* value) const = 0;
  virtual void check(const void* value, const std::string& path) const = 0;
};

/// A type whose values are T. The types below say how one is read, printed and checked.
template <class T>
class FieldOf : public FieldType {
 public:
  void read(void* value, const YamlNode& node) const override { read_value(*static_cast<T*>(value), node); }
  std::string print(const void* value) const override { return text_of(*static_cast<const T*>(value)); }
  void check(const void* value, const std::string& path) const override {
    check_value(*static_cast<const T*>(value), path);
  }

 private:
  virtual void read_value(T& value, const YamlNode& node) const = 0;
  virtual std::string text_of(const T& value) const = 0;
  virtual void check_value(const T&, const std::string&) const {}
};

template <class T>
void check_range(T value, Range<T> range, const std::string& path) {
  if (!(value >= range.min && value <= range.max))
    throw ConfigError(path,
                      "expected " + range_text(range.min, range.max) + ", got `" + number_text(value) + "`");
}

template <class T>
std::string shown_list(const std::vector<T>& values) {
  std::vector<std::string> words;
  for (const T value : values) words.push_back(number_text(static_cast<double>(value)));
  return "[" + joined(words) + "]";
}

class RealField final : public FieldOf<double> {
 public:
  explicit RealField(Range<double> range) : range_(range) {}

 private:
  void read_value(double& value, const YamlNode& node) const override { value = node.real(); }
  std::string text_of(const double& value) const override { return number_text(value); }
  void check_value(const double& value, const std::string& path) const override {
    check_range(value, range_, path);
  }
  Range<double> range_;
};

class IntegerField final : public FieldOf<int> {
 public:
  explicit IntegerField(Range<int> range) : range_(range) {}

 private:
  void read_value(int& value, const YamlNode& node) const override { value = node.integer(); }
  std::string text_of(const int& value) const override { return std::to_string(value); }
  void check_value(const int& value, const std::string& path) const override {
    check_range(value, range_, path);
  }
  Range<int> range_;
};

class FlagField final : public FieldOf<bool> {
  void read_value(bool& value, const YamlNode& node) const override { value = node.flag(); }
  std::string text_of(const bool& value) const override { return value ? "true" : "false"; }
};

class TextField final : public FieldOf<std::string> {
  void read_value(std::string& value, const YamlNode& node) const override { value = node.text(); }
  std::string text_of(const std::string& value) const override { return value; }
};

class WordsField final : public FieldOf<std::vector<std::string>> {
  void read_value(std::vector<std::string>& value, const YamlNode& node) const override {
    value = node.texts();
  }
  std::string text_of(const std::vector<std::string>& value) const override {
    return "[" + joined(value) + "]";
  }
};

class RealsField final : public FieldOf<std::vector<double>> {
 public:
  explicit RealsField(Range<double> range) : range_(range) {}

 private:
  void read_value(std::vector<double>& value, const YamlNode& node) const override { value = node.reals(); }
  std::string text_of(const std::vector<double>& value) const override { return shown_list(value); }
  void check_value(const std::vector<double>& value, const std::string& path) const override {
    for (const double entry : value) check_range(entry, range_, path);
  }
  Range<double> range_;
};

class IntegersField final : public FieldOf<std::vector<int>> {
 public:
  explicit IntegersField(Range<int> range) : range_(range) {}

 private:
  void read_value(std::vector<int>& value, const YamlNode& node) const override { value = node.integers(); }
  std::string text_of(const std::vector<int>& value) const override { return shown_list(value); }
  void check_value(const std::vector<int>& value, const std::string& path) const override {
    for (const int entry : value) check_range(entry, range_, path);
  }
  Range<int> range_;
};

/// The value of an enumeration, as the int that it is stored as.
class ChoiceField final : public FieldType {
 public:
  ChoiceField(std::vector<std::string> words, std::vector<int> values)
      : words_(std::move(words)), values_(std::move(values)) {}

  void read(void* value, const YamlNode& node) const override {
    const std::string word = node.text();
    const auto found = std::find(words_.begin(), words_.end(), word);
    if (found == words_.end()) node.fail(expected_one_of(words_, word));
    std::memcpy(value, &values_[static_cast<std::size_t>(found - words_.begin())], sizeof(int));
  }
  std::string print(const void* value) const override {
    int number = 0;
    std::memcpy(&number, value, sizeof(int));
    const auto found = std::find(values_.begin(), values_.end(), number);
    return found == values_.end() ? "?" : words_[static_cast<std::size_t>(found - values_.begin())];
  }
  void check(const void*, const std::string&) const override {}

 private:
  std::vector<std::string> words_;
  std::vector<int> values_;
};

class GroupField final : public FieldType {
 public:
  explicit GroupField(const AnyFields& (*fields)()) : fields_(fields) {}

  void read(void* value, const YamlNode& node) const override { read_all(fields_(), node, value, {}); }
  std::string print(const void*) const override { return "its own defaults"; }
  void check(const void* value, const std::string& path) const override { check_all(fields_(), value, path); }

 private:
  const AnyFields& (*fields_)();
};

DYNFILTER_INLINE void AnyField::read(void* p, const YamlNode& node) const {
  type->read(static_cast<char*>(p) + offset, node);
  check(p, node.path());
}

DYNFILTER_INLINE void AnyField::check(const void* p, const std::string& path) const {
  type->check(static_cast<const char*>(p) + offset, path);
}

DYNFILTER_INLINE std::string AnyField::print(const void* p) const {
  return type->print(static_cast<const char*>(p) + offset);
}

DYNFILTER_INLINE AnyField real_field(const char* name, std::size_t offset, const char* unit, double min,
                                     double max, const char* doc) {
  return {{name, "number", unit, "", range_text(min, max), doc},
          offset,
          std::make_shared<RealField>(Range<double>{min, max})};
}

DYNFILTER_INLINE AnyField integer_field(const char* name, std::size_t offset, const char* unit, int min,
                                        int max, const char* doc) {
  return {{name, "integer", unit, "", range_text(min, max), doc},
          offset,
          std::make_shared<IntegerField>(Range<int>{min, max})};
}

DYNFILTER_INLINE AnyField flag_field(const char* name, std::size_t offset, const char* doc) {
  return {{name, "flag", "", "", "true, false", doc}, offset, std::make_shared<FlagField>()};
}

DYNFILTER_INLINE AnyField text_field(const char* name, std::size_t offset, const char* doc) {
  return {{name, "text", "", "", "", doc}, offset, std::make_shared<TextField>()};
}

DYNFILTER_INLINE AnyField words_field(const char* name, std::size_t offset, const char* doc) {
  return {{name, "list of words", "", "", "", doc}, offset, std::make_shared<WordsField>()};
}

DYNFILTER_INLINE AnyField reals_field(const char* name, std::size_t offset, const char* unit, double min,
                                      double max, const char* doc) {
  return {{name, "list of numbers", unit, "", range_text(min, max), doc},
          offset,
          std::make_shared<RealsField>(Range<double>{min, max})};
}

DYNFILTER_INLINE AnyField integers_field(const char* name, std::size_t offset, int min, int max,
                                         const char* doc) {
  return {{name, "list of integers", "", "", range_text(min, max), doc},
          offset,
          std::make_shared<IntegersField>(Range<int>{min, max})};
}

DYNFILTER_INLINE AnyField choice_field(const char* name, std::size_t offset, const char* const* words,
                                       const int* values, std::size_t count, const char* doc) {
  const std::vector<std::string> names(words, words + count);
  return {{name, "choice", "", "", joined(names), doc},
          offset,
          std::make_shared<ChoiceField>(names, std::vector<int>(values, values + count))};
}

DYNFILTER_INLINE AnyField group_field(const char* name, std::size_t offset, const AnyFields& (*fields)(),
                                      const char* doc) {
  return {{name, "map", "", "", "", doc}, offset, std::make_shared<GroupField>(fields)};
}

DYNFILTER_INLINE void include_all(AnyFields& table, const AnyFields& added, std::size_t offset) {
  for (AnyField field : added) {
    field.offset += offset;
    table.push_back(std::move(field));
  }
}

DYNFILTER_INLINE void check_all(const AnyFields& table, const void* p, const std::string& path) {
  for (const AnyField& field : table)
    field.check(p, path.empty() ? field.info.name : path + "." + field.info.name);
}

DYNFILTER_INLINE void read_all(const AnyFields& table, const YamlNode& node, void* p,
                               const std::vector<std::string>& other_keys) {
  for (const auto& [key, value] : node.entries()) {
    if (std::find(other_keys.begin(), other_keys.end(), key) != other_keys.end()) continue;
    const AnyField* field = nullptr;
    for (const AnyField& candidate : table)
      if (candidate.info.name == key) field = &candidate;
    if (field == nullptr) {
      std::vector<std::string> known = other_keys;
      for (const AnyField& candidate : table) known.push_back(candidate.info.name);
      node.fail(unknown_name("key", key, known));
    }
    field->read(p, value);
  }
}

DYNFILTER_INLINE std::vector<FieldInfo> describe_all(const AnyFields& table, const void* defaults) {
  std::vector<FieldInfo> infos;
  for (const AnyField& field : table) {
    infos.push_back(field.info);
    infos.back().default_value = field.print(defaults);
  }
  return infos;
}

}  // namespace detail

}  // namespace dynfilter
