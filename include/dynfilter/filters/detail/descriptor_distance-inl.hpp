// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/filters/descriptor_distance.hpp>

#include <cstddef>
#include <cstdint>
#include <dynfilter/core/inline.hpp>
#include <dynfilter/correspondence/match.hpp>
#include <dynfilter/evidence/matched_features.hpp>

namespace dynfilter {

DYNFILTER_INLINE const FieldTable<DescriptorDistanceParams>& DescriptorDistanceParams::fields() {
  using P = DescriptorDistanceParams;
  static const FieldTable<P> table{
      integer("max_distance_bits", &P::max_distance_bits, "bits", {0, 65536},
              "largest Hamming distance of matched descriptors that counts as similar"),
      real("max_offset_px", &P::max_offset_px, "px", {0, 100},
           "flow: largest distance between the end of the flow and the feature of the earlier frame that "
           "counts as its match"),
      flag("keyframe", &P::keyframe, "compare with the last keyframe instead of gap_frames back"),
      integer("gap_frames", &P::gap_frames, "frames", {1, 30}, "number of frames back"),
  };
  return table;
}

DYNFILTER_INLINE DescriptorDistanceFilter::DescriptorDistanceFilter(Params params) : params_(params) {
  check_parameters(params_, kName);
}

DYNFILTER_INLINE void DescriptorDistanceFilter::apply(const Evidence& evidence, Votes& votes) {
  const Match& match = evidence.match({params_.keyframe, params_.gap_frames});
  if (match.reference == nullptr) return votes.note("no earlier frame");
  const MatchedFeatures& matched = evidence.matched_features(match, params_.max_offset_px);
  if (!matched.has_descriptors()) return votes.note("the earlier frame has no descriptors like these");
  for (std::size_t i = 0; i < evidence.size(); ++i) {
    const std::int32_t bits = matched.distance_bits(i);
    if (!evidence.judged(i) || bits < 0) continue;
    const float missed = 1 - suspicion(bits, params_.max_distance_bits);
    votes.cast(i, bits <= params_.max_distance_bits ? Vote::Dynamic : Vote::Static, missed);
  }
}

}  // namespace dynfilter
