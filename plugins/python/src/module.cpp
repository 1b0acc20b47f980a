// SPDX-License-Identifier: MIT
#include <pybind11/stl.h>

#include <dynfilter/config/near_miss.hpp>
#include <dynfilter/version.hpp>
#include <string>

#include "bindings.hpp"

namespace {

namespace py = pybind11;

/// pybind11 before 2.12 reads NumPy's objects by the layout of NumPy 1.
constexpr bool kOldLayout = PYBIND11_VERSION_HEX < 0x020C0000;

/// Raises an ImportError that says what to install. Without it the import of `_core` fails with
/// "initialization failed".
void check_numpy() {
  std::string version;
  try {
    version = py::module_::import("numpy").attr("__version__").cast<std::string>();
  } catch (const py::error_already_set&) {
    throw py::import_error(
        "dynfilter needs NumPy: run `pip install \"numpy<2\"`, or install Debian's python3-numpy");
  }
  if (kOldLayout && std::stoi(version) >= 2)
    throw py::import_error("dynfilter needs NumPy below 2 with this pybind11, found " + version +
                           ": run `pip install \"numpy<2\"`");
}

}  // namespace

PYBIND11_MODULE(_core, module) {
  using namespace dynfilter::python;
  module.doc() = "The compiled part of dynfilter. Import `dynfilter` instead.";
  module.attr("__version__") = DYNFILTER_VERSION;
  check_numpy();
  bind_errors(module);
  bind_frame(module);
  bind_motion(module);
  bind_evidence(module);
  bind_registry(module);
  bind_verdict(module);
  bind_pipeline(module);
  bind_exact_scene(module);
  bind_sequences(module);
  bind_evaluation(module);
  bind_comparison(module);
  bind_mapping(module);
  bind_odometry(module);
  module.def("_unknown_name", &dynfilter::unknown_name, py::arg("what"), py::arg("word"), py::arg("known"));
}
