// SPDX-License-Identifier: MIT
// The functions of what main.cpp includes: then no library is needed, and main.cpp defines nothing.
#define DYNFILTER_HEADER_ONLY
#define DYNFILTER_IMPLEMENTATION
#include <dynfilter/config/registry.hpp>
