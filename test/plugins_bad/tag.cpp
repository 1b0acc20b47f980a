// SPDX-License-Identifier: MIT
// The right tag, compiled once for all of them.
#include <dynfilter/plugin/export.hpp>

DYNFILTER_PLUGIN_TAG();
