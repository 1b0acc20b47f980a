// SPDX-License-Identifier: MIT
#include <pybind11/pybind11.h>

#include <dynfilter/core/error.hpp>
#include <exception>

#include "bindings.hpp"

namespace dynfilter::python {
namespace py = pybind11;
namespace {

py::object error_class(const char* name) {
  return py::module_::import("dynfilter.errors").attr(name);
}

void set_error(const char* name, const std::exception& error) {
  PyErr_SetString(error_class(name).ptr(), error.what());
}

void set_config_error(const ConfigError& error) {
  const py::object type = error_class("ConfigError");
  const py::object raised = type(error.what());
  raised.attr("path") = error.path();
  PyErr_SetObject(type.ptr(), raised.ptr());
}

}  // namespace

void bind_errors(py::module_& /*module*/) {
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const ConfigError& error) {
      set_config_error(error);
    } catch (const PluginError& error) {
      set_error("PluginError", error);
    } catch (const IoError& error) {
      set_error("IoError", error);
    } catch (const Error& error) {
      set_error("Error", error);
    }
  });
}

}  // namespace dynfilter::python
