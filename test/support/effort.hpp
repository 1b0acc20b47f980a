// SPDX-License-Identifier: MIT
#pragma once

namespace dynfilter_test {

/// Under the sanitizers, where a few scenes or presets stand for all that the release build runs.
#ifdef DYNFILTER_SLOW_BUILD
inline constexpr bool kSlowBuild = true;
#else
inline constexpr bool kSlowBuild = false;
#endif

/// With the option DYNFILTER_LONG_TESTS (test/run.sh --long) the longest tests have all of their recordings,
/// ways and arrangements, otherwise a part of them.
#ifdef DYNFILTER_LONG_TESTS
inline constexpr bool kLongTests = true;
#else
inline constexpr bool kLongTests = false;
#endif

}  // namespace dynfilter_test
