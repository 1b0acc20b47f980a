// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/config/field_table.hpp>

namespace dynfilter {

struct DescriptorMatchParams {
  double search_radius_px = 50;
  int max_octave_difference = 1;
  int max_distance_bits = 64;
  double max_ratio = 0.9;
  bool mutual = true;

  static const FieldTable<DescriptorMatchParams>& fields();
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/correspondence/detail/descriptor_match_params-inl.hpp>
#endif
