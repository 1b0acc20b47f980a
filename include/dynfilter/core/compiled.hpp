// SPDX-License-Identifier: MIT
#pragma once

/// The toolkit is headers. What takes longest to compile in them is in the library dynfilter::compiled as
/// well; with DYNFILTER_COMPILED (that target defines it) the headers only declare it.
#ifdef DYNFILTER_COMPILED
#define DYNFILTER_INLINE
#else
#define DYNFILTER_INLINE inline
#endif
