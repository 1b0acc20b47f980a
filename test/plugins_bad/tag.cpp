// SPDX-License-Identifier: MIT
// The correct tag, compiled once for all plugins.
#include <dynfilter/plugin/export.hpp>

DYNFILTER_PLUGIN_TAG();
