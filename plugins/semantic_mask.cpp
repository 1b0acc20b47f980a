// SPDX-License-Identifier: MIT
#include <dynfilter/filters/semantic_mask.hpp>
#include <dynfilter/plugin/export.hpp>

DYNFILTER_EXPORT_FILTERS(dynfilter::SemanticMaskFilter);
