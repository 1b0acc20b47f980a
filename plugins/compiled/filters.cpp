// SPDX-License-Identifier: MIT
#include <dynfilter/filters/builtin_table.hpp>
