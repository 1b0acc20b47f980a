// SPDX-License-Identifier: MIT
#include <dynfilter/filters/descriptor_distance.hpp>
#include <dynfilter/plugin/export.hpp>

DYNFILTER_EXPORT_FILTERS(dynfilter::DescriptorDistanceFilter);
