// SPDX-License-Identifier: MIT
#include "multi_model.hpp"

#include <dynfilter/plugin/export.hpp>

DYNFILTER_EXPORT_FILTERS(multi_model::MultiModelFilter);
