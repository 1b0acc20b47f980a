// SPDX-License-Identifier: MIT
// Built with wider vector instructions (-mavx), which increase Eigen's alignment.
// The mismatch is real, not an invented number.
#include <dynfilter/plugin/export.hpp>

#include "harmless.hpp"

DYNFILTER_EXPORT_FILTERS(bad::Harmless);
