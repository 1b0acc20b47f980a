// SPDX-License-Identifier: MIT
#include <dynfilter/filters/trajectory_consistency.hpp>
#include <dynfilter/plugin/export.hpp>

DYNFILTER_EXPORT_FILTERS(dynfilter::TrajectoryConsistencyFilter);
