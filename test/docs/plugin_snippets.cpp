// SPDX-License-Identifier: MIT
#include <dynfilter/core/parameters.hpp>

#include "plugins_1.inc"
