// SPDX-License-Identifier: MIT
#pragma once

namespace dynfilter_test {

/// Under the sanitizers, where a few scenes or presets stand for all that the release build runs.
#ifdef DYNFILTER_SLOW_BUILD
inline constexpr bool kSlowBuild = true;
#else
inline constexpr bool kSlowBuild = false;
#endif

}  // namespace dynfilter_test
