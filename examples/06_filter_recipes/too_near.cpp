// SPDX-License-Identifier: MIT
#include <dynfilter/plugin/export.hpp>

#include "recipes.hpp"

DYNFILTER_EXPORT_FILTERS(recipes::TooNear);
