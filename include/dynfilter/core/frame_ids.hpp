// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>

namespace dynfilter {

/// `later` - `earlier`, or the nearest number that there is: a host's ids may be any numbers.
constexpr std::int64_t id_gap(std::int64_t later, std::int64_t earlier) {
  constexpr auto kMost = static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max());
  const auto a = static_cast<std::uint64_t>(later), b = static_cast<std::uint64_t>(earlier);
  return later >= earlier ? static_cast<std::int64_t>(std::min(a - b, kMost))
                          : -static_cast<std::int64_t>(std::min(b - a, kMost));
}

}  // namespace dynfilter
