// SPDX-License-Identifier: MIT
#pragma once

/// Headers declare, and `detail/NAME-inl.hpp` beside them contains their functions, for the libraries.
/// Without these, all files define DYNFILTER_HEADER_ONLY: each header includes its functions. Or one file
/// defines it and DYNFILTER_IMPLEMENTATION, and has the functions of what it includes for the others.
/// All files of a program must be compiled in the same one of these ways.
#if defined(DYNFILTER_HEADER_ONLY) && !defined(DYNFILTER_IMPLEMENTATION)
#define DYNFILTER_INLINE inline
#else
#define DYNFILTER_INLINE
#endif
