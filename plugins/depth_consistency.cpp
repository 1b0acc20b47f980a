// SPDX-License-Identifier: MIT
#include <dynfilter/filters/depth_consistency.hpp>
#include <dynfilter/plugin/export.hpp>

DYNFILTER_EXPORT_FILTERS(dynfilter::DepthConsistencyFilter);
