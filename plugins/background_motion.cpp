// SPDX-License-Identifier: MIT
#include <dynfilter/filters/background_motion.hpp>
#include <dynfilter/plugin/export.hpp>

DYNFILTER_EXPORT_FILTERS(dynfilter::BackgroundMotionFilter);
