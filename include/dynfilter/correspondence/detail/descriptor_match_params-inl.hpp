// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/correspondence/descriptor_match_params.hpp>

#include <dynfilter/core/inline.hpp>
#include <dynfilter/config/parameters.hpp>

namespace dynfilter {

DYNFILTER_INLINE const FieldTable<DescriptorMatchParams>& DescriptorMatchParams::fields() {
  using P = DescriptorMatchParams;
  static const FieldTable<P> table{
      real("search_radius_px", &P::search_radius_px, "px", {0.5, 10000},
           "radius around the expected position that is searched"),
      integer("max_octave_difference", &P::max_octave_difference, "", {0, 100},
              "largest octave difference of the two features"),
      integer("max_distance_bits", &P::max_distance_bits, "bits", {0, 65536},
              "largest Hamming distance of a match"),
      real("max_ratio", &P::max_ratio, "", {0, 1}, "largest ratio of the best to the second-best distance"),
      flag("mutual", &P::mutual, "accept only matches that are the best in both directions"),
  };
  return table;
}

}  // namespace dynfilter
