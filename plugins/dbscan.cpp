// SPDX-License-Identifier: MIT
#include <dynfilter/filters/dbscan.hpp>
#include <dynfilter/plugin/export.hpp>

DYNFILTER_EXPORT_FILTERS(dynfilter::DbscanFilter);
