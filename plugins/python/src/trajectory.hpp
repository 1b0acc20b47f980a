// SPDX-License-Identifier: MIT
#pragma once

#include <pybind11/pybind11.h>

#include <string>

#include "io/trajectory.hpp"

namespace dynfilter::python {

/// (timestamps (n,) [s], poses (n, 4, 4) T_world_camera).
pybind11::tuple arrays_of(const io::Trajectory& trajectory);

/// The other way round, sorted by time. `argument`: its name in errors.
io::Trajectory trajectory_of(const std::string& argument, pybind11::handle value);

}  // namespace dynfilter::python
