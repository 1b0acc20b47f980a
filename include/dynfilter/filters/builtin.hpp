// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/registry.hpp>

namespace dynfilter {

/// A registry with all rejectors of the toolkit.
Registry builtin_filters();

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/filters/detail/builtin-inl.hpp>
#endif
