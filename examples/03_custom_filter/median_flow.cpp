// SPDX-License-Identifier: MIT
#include "median_flow.hpp"

#include <dynfilter/plugin/export.hpp>

DYNFILTER_EXPORT_FILTERS(mine::MedianFlowFilter);
