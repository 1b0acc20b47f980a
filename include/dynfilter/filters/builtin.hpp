// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/compiled.hpp>
#include <dynfilter/core/registry.hpp>

namespace dynfilter {

/// A registry with all rejectors of the toolkit.
DYNFILTER_INLINE Registry builtin_filters();

}  // namespace dynfilter

#ifndef DYNFILTER_COMPILED
#include <dynfilter/filters/builtin_table.hpp>
#endif
