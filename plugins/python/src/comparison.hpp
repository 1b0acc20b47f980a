// SPDX-License-Identifier: MIT
#pragma once

#include <pybind11/pybind11.h>

#include <string>

#include "eval/comparison.hpp"

namespace dynfilter::python {

/// Of a dynfilter.Run.
eval::ComparedRun compared_run(pybind11::handle run);
eval::Comparison compared(const pybind11::iterable& runs, const std::string& reference);

}  // namespace dynfilter::python
