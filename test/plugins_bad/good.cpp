// SPDX-License-Identifier: MIT
// A correct plugin, for comparison with the others.
#include <dynfilter/plugin/export.hpp>

#include "harmless.hpp"

DYNFILTER_EXPORT_FILTERS(bad::Harmless, bad::Named<'b'>);
