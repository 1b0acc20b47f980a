// SPDX-License-Identifier: MIT
#include "python_filter.hpp"

#include <pybind11/stl.h>

#include <algorithm>
#include <dynfilter/config/near_miss.hpp>
#include <dynfilter/config/numbers.hpp>
#include <dynfilter/config/parameters.hpp>
#include <dynfilter/core/error.hpp>
#include <stdexcept>
#include <utility>
#include <vector>

#include "evidence.hpp"
#include "registered.hpp"

namespace dynfilter::python {
namespace {

/// A parameter, as dynfilter/filters.py describes it.
struct PythonField {
  FieldInfo info;
  double min, max;
  std::vector<std::string> choices;
};

const std::pair<const char*, Input> kInputs[] = {
    {"grey", Input::GreyImage},          {"depth", Input::Depth},
    {"camera", Input::Camera},           {"pose", Input::Pose},
    {"boxes", Input::Detections},        {"mask", Input::Mask},
    {"descriptors", Input::Descriptors}, {"map_points", Input::MapPoints},
    {"keyframes", Input::Keyframes},     {"matches", Input::Correspondence}};

Input input_of(const std::string& name) {
  std::vector<std::string> known;
  for (const auto& [word, input] : kInputs) {
    if (name == word) return input;
    known.emplace_back(word);
  }
  refuse_name("needs", known, name);
}

Needs needs_of(py::handle filter_class) {
  return {inputs_of(filter_class.attr("needs")), inputs_of(filter_class.attr("optional")),
          filter_class.attr("history_frames").cast<int>()};
}

std::vector<PythonField> fields_of(py::handle filter_class) {
  std::vector<PythonField> fields;
  for (const py::handle f : filter_class.attr("_fields")()) {
    const auto text = [&](const char* key) { return f.attr(key).cast<std::string>(); };
    fields.push_back({{text("name"), text("kind"), text("unit"), text("default"), text("range"), text("doc")},
                      f.attr("min").cast<double>(),
                      f.attr("max").cast<double>(),
                      f.attr("choices").cast<std::vector<std::string>>()});
  }
  return fields;
}

double in_range(const PythonField& field, const YamlNode& node, double value) {
  if (!(value >= field.min && value <= field.max))
    node.fail("expected " + field.info.range + ", got `" + dynfilter::number_text(value) + "`");
  return value;
}

template <class T>
py::object all_in_range(const PythonField& field, const YamlNode& node, const std::vector<T>& values) {
  for (const T value : values) in_range(field, node, static_cast<double>(value));
  return py::cast(values);
}

std::string chosen(const PythonField& field, const YamlNode& node) {
  const std::string word = node.text();
  if (std::find(field.choices.begin(), field.choices.end(), word) == field.choices.end())
    node.fail(expected_one_of(field.choices, word));
  return word;
}

py::object value_of(const PythonField& field, const YamlNode& node) {
  const std::string& kind = field.info.type;
  if (kind == "number") return py::float_(in_range(field, node, node.real()));
  if (kind == "integer") {
    const int value = node.integer();
    in_range(field, node, value);
    return py::int_(value);
  }
  if (kind == "flag") return py::bool_(node.flag());
  if (kind == "choice") return py::str(chosen(field, node));
  if (kind == "list of words") return py::cast(node.texts());
  if (kind == "list of numbers") return all_in_range(field, node, node.reals());
  if (kind == "list of integers") return all_in_range(field, node, node.integers());
  return py::str(node.text());
}

py::dict arguments_of(py::handle filter_class, const YamlNode& node) {
  const std::vector<PythonField> fields = fields_of(filter_class);
  py::dict arguments;
  for (const auto& [key, value] : node.entries()) {
    const auto field = std::find_if(fields.begin(), fields.end(),
                                    [name = key](const PythonField& f) { return f.info.name == name; });
    if (field == fields.end()) {
      std::vector<std::string> known;
      for (const PythonField& f : fields) known.push_back(f.info.name);
      node.fail(unknown_name("key", key, known));
    }
    arguments[py::str(key)] = value_of(*field, value);
  }
  return arguments;
}

/// A ValueError of the class is about the parameters.
py::object made(const py::object& filter_class, const YamlNode& node) {
  const py::dict arguments = arguments_of(filter_class, node);
  try {
    return filter_class(**arguments);
  } catch (py::error_already_set& error) {
    if (!error.matches(PyExc_ValueError)) throw;
    throw ConfigError(node.path(), py::str(error.value()).cast<std::string>());
  }
}

}  // namespace

Input inputs_of(py::handle names) {
  Input inputs = Input::None;
  for (const py::handle name : names) inputs = inputs | input_of(name.cast<std::string>());
  return inputs;
}

PythonFilter::PythonFilter(py::object object, std::shared_ptr<FilterLink> link)
    : object_(std::move(object)),
      link_(std::move(link)),
      name_(object_.attr("name").cast<std::string>()),
      needs_(needs_of(object_)) {}

PythonFilter::~PythonFilter() {
  const py::gil_scoped_acquire gil;
  object_ = py::object();
}

void PythonFilter::apply(const Evidence& evidence, Votes& votes) {
  const py::gil_scoped_acquire gil;
  const OpenEvidence open(evidence, votes, link_->images);
  try {
    object_.attr("apply")(open.evidence(), open.votes());
  } catch (py::error_already_set& error) {
    report(error);
  }
}

void PythonFilter::reset() {
  const py::gil_scoped_acquire gil;
  object_.attr("reset")();
}

/// The stage reports the text. The caller of the pipeline gets the exception itself.
void PythonFilter::report(py::error_already_set& error) {
  const std::string text = py::str(error.value()).cast<std::string>();
  const std::string type = py::str(error.type().attr("__name__")).cast<std::string>();
  if (!link_->error) link_->error = std::make_exception_ptr(error);
  throw std::runtime_error(type + ": " + text);
}

FilterCard card_of(py::handle filter_class) {
  FilterCard card;
  card.name = filter_class.attr("name").cast<std::string>();
  card.summary = filter_class.attr("summary").cast<std::string>();
  card.needs = needs_of(filter_class);
  for (const PythonField& field : fields_of(filter_class)) card.parameters.push_back(field.info);
  return card;
}

Registry registry(const std::shared_ptr<FilterLink>& link) {
  Registry all = compiled_filters();
  const py::dict classes = py::module_::import("dynfilter.filters").attr("registered");
  for (const auto& [name, filter_class] : classes) {
    const auto type = py::reinterpret_borrow<py::object>(filter_class);
    all.add({card_of(type), [type, link](const YamlNode& node) -> std::unique_ptr<Filter> {
               return std::make_unique<PythonFilter>(made(type, node), link);
             }});
  }
  return all;
}

}  // namespace dynfilter::python
