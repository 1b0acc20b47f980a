// SPDX-License-Identifier: MIT
#pragma once

/// Every header declares; the bodies are in detail/*-inl.hpp. With DYNFILTER_HEADER_ONLY defined each header
/// includes its bodies, otherwise the library dynfilter::dynfilter has them. One program uses one of the two.
#ifdef DYNFILTER_HEADER_ONLY
#define DYNFILTER_INLINE inline
#else
#define DYNFILTER_INLINE
#endif
