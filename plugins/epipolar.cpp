// SPDX-License-Identifier: MIT
#include <dynfilter/filters/epipolar.hpp>
#include <dynfilter/plugin/export.hpp>

DYNFILTER_EXPORT_FILTERS(dynfilter::EpipolarFilter);
