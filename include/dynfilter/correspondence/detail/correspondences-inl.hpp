// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/correspondence/correspondences.hpp>

#include <dynfilter/core/inline.hpp>

namespace dynfilter {

DYNFILTER_INLINE void Correspondences::reset(std::size_t n) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  reference_px.assign(n, {kNan, kNan});
  found.assign(n, 0);
  reference_index.assign(n, -1);
}

}  // namespace dynfilter
