// SPDX-License-Identifier: MIT
// Exports two filters of one name.
#include "harmless.hpp"

DYNFILTER_REGISTER_FILTERS(bad::Named<'d'>, bad::Named<'d'>);
