// SPDX-License-Identifier: MIT
#pragma once

/// Headers declare, and `detail/NAME-inl.hpp` beside them contains their functions.
/// The libraries of dynfilter's CMake targets are compiled from these.
/// With DYNFILTER_HEADER_ONLY each header includes its functions, and no library is needed.
/// All files of a program must be compiled the same way: with the libraries, or header-only.
#ifdef DYNFILTER_HEADER_ONLY
#define DYNFILTER_INLINE inline
#else
#define DYNFILTER_INLINE
#endif
