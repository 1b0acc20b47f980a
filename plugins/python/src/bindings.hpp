// SPDX-License-Identifier: MIT
#pragma once

#include <pybind11/pybind11.h>

/// One function per part of the module. Types are declared before the functions that use them.
namespace dynfilter::python {

void bind_errors(pybind11::module_& module);
void bind_frame(pybind11::module_& module);
void bind_motion(pybind11::module_& module);
void bind_evidence(pybind11::module_& module);
void bind_registry(pybind11::module_& module);
void bind_verdict(pybind11::module_& module);
void bind_pipeline(pybind11::module_& module);
void bind_exact_scene(pybind11::module_& module);
void bind_sequences(pybind11::module_& module);
void bind_evaluation(pybind11::module_& module);
void bind_comparison(pybind11::module_& module);
void bind_mapping(pybind11::module_& module);
void bind_odometry(pybind11::module_& module);

}  // namespace dynfilter::python
