// SPDX-License-Identifier: MIT
#include <dynfilter/config/parameters.hpp>

#include "plugins_1.inc"
