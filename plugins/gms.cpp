// SPDX-License-Identifier: MIT
#include <dynfilter/filters/gms.hpp>
#include <dynfilter/plugin/export.hpp>

DYNFILTER_EXPORT_FILTERS(dynfilter::GmsFilter);
