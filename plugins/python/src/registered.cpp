// SPDX-License-Identifier: MIT
#include "registered.hpp"

#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <dynfilter/pipeline/builtin_filters.hpp>
#include <dynfilter/plugin/loader.hpp>
#include <string>
#include <vector>

#include "bindings.hpp"
#include "python_filter.hpp"

namespace dynfilter::python {
namespace {

std::vector<FilterCard> cards() {
  const Registry all = registry(std::make_shared<FilterLink>());
  std::vector<FilterCard> list;
  for (const std::string& name : all.names()) list.push_back(all.find(name)->card);
  return list;
}

std::string card_text(const FilterCard& card) {
  std::string text = card.name + ": " + card.summary + "\nneeds: " + to_string(card.needs.required);
  for (const FieldInfo& p : card.parameters) {
    text += "\n  " + p.name + " = " + p.default_value;
    if (!p.unit.empty()) text += " [" + p.unit + "]";
    if (!p.range.empty()) text += ", " + p.range;
    text += ": " + p.doc;
  }
  return text;
}

}  // namespace

Registry& compiled_filters() {
  static Registry filters = builtin_filters();
  return filters;
}

const PresetFolders& preset_folders() {
  static const PresetFolders folders = [] {
    PresetFolders own;
    own.installed.emplace_back(
        py::module_::import("dynfilter.paths").attr("pipelines_folder").cast<std::string>());
    return own;
  }();
  return folders;
}

void bind_registry(py::module_& module) {
  py::class_<FieldInfo>(module, "Parameter", "A parameter of a filter, as its card prints it.")
      .def_readonly("name", &FieldInfo::name)
      .def_readonly("type", &FieldInfo::type)
      .def_readonly("unit", &FieldInfo::unit)
      .def_readonly("default", &FieldInfo::default_value)
      .def_readonly("range", &FieldInfo::range)
      .def_readonly("doc", &FieldInfo::doc)
      .def("__repr__",
           [](const FieldInfo& p) { return "Parameter(" + p.name + " = " + p.default_value + ")"; });
  py::class_<FilterCard>(module, "FilterCard", "What a filter needs and which parameters it has.")
      .def_readonly("name", &FilterCard::name)
      .def_readonly("summary", &FilterCard::summary)
      .def_readonly("parameters", &FilterCard::parameters)
      .def_property_readonly("needs", [](const FilterCard& card) { return to_string(card.needs.required); })
      .def("__str__", &card_text)
      .def("__repr__", [](const FilterCard& card) { return "FilterCard(" + card.name + ")"; });
  module.def("filter_cards", &cards,
             "Cards of all filters: of the toolkit, of plugins and written in Python.");
  module.def(
      "is_compiled_filter", [](const std::string& name) { return compiled_filters().find(name) != nullptr; },
      py::arg("name"));
  module.def(
      "_check_inputs", [](py::handle names) { inputs_of(names); }, py::arg("names"));
  module.def(
      "presets", [] { return preset_names(preset_folders()); }, "Names of the pipelines that are installed.");
  module.def(
      "load_plugin", [](const std::string& path) { return load_plugin(path, compiled_filters()); },
      py::arg("path"),
      "Loads a C++ plugin and returns the names of its filters. This runs code of the file.\n"
      "Raises PluginError.");
}

}  // namespace dynfilter::python
