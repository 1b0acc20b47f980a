// SPDX-License-Identifier: MIT
// Built with wider vector instructions (-mavx), with which Eigen aligns to more bytes: a real mismatch, not a
// made-up number.
#include <dynfilter/plugin/export.hpp>

#include "harmless.hpp"

DYNFILTER_EXPORT_FILTERS(bad::Harmless);
