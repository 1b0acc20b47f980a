// SPDX-License-Identifier: MIT
#include <dynfilter/filters/flow_consistency.hpp>
#include <dynfilter/plugin/export.hpp>

DYNFILTER_EXPORT_FILTERS(dynfilter::FlowConsistencyFilter);
