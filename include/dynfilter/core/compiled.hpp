// SPDX-License-Identifier: MIT
#pragma once

/// The library dynfilter::compiled contains the functions that take longest to compile.
/// Its target defines DYNFILTER_COMPILED, and the headers then only declare these functions.
/// Without it the headers also define them.
#ifdef DYNFILTER_COMPILED
#define DYNFILTER_INLINE
#else
#define DYNFILTER_INLINE inline
#endif
