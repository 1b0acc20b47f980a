// SPDX-License-Identifier: MIT
#include <dynfilter/filters/box_blur.hpp>
#include <dynfilter/plugin/export.hpp>

DYNFILTER_EXPORT_FILTERS(dynfilter::BoxBlurFilter);
