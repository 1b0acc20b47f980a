// SPDX-License-Identifier: MIT
// Nothing is wrong with this one: what the others are compared with.
#include <dynfilter/plugin/export.hpp>

#include "harmless.hpp"

DYNFILTER_EXPORT_FILTERS(bad::Harmless, bad::Named<'b'>);
