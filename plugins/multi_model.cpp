// SPDX-License-Identifier: MIT
#include <dynfilter/filters/multi_model.hpp>
#include <dynfilter/plugin/export.hpp>

DYNFILTER_EXPORT_FILTERS(dynfilter::MultiModelFilter);
