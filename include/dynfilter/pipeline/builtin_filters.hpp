// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/config/registry.hpp>

namespace dynfilter {

/// A registry with all rejectors of the toolkit.
Registry builtin_filters();

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/pipeline/detail/builtin_filters-inl.hpp>
#endif
