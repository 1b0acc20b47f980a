// SPDX-License-Identifier: MIT
#include <dynfilter/filters/map_point_belief.hpp>
#include <dynfilter/plugin/export.hpp>

DYNFILTER_EXPORT_FILTERS(dynfilter::MapPointBeliefFilter);
