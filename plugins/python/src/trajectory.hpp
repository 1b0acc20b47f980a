// SPDX-License-Identifier: MIT
#pragma once

#include <pybind11/pybind11.h>

#include "io/trajectory.hpp"

namespace dynfilter::python {

/// (timestamps (n,) [s], poses (n, 4, 4) T_world_camera).
pybind11::tuple arrays_of(const io::Trajectory& trajectory);

}  // namespace dynfilter::python
