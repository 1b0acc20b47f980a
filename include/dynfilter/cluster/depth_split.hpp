// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

namespace dynfilter {

/// Splits the depths of a box into two surfaces: the largest depth [m] of the nearer one.
/// Applies the threshold of Otsu (1979) to inverse depths. Sorts `inverse` [1/m].
/// The means must differ by at least 15 %, and the near side must have 10 % of the samples.
/// Otherwise, and for fewer than 8 samples, there is one surface and the result is infinity.
double nearer_surface_m(std::vector<float>& inverse);

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/cluster/detail/depth_split-inl.hpp>
#endif
