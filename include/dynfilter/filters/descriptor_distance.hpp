// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <dynfilter/config/registry.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/evidence/evidence.hpp>

namespace dynfilter {

struct DescriptorDistanceParams {
  int max_distance_bits = 50;
  /// Flow: largest distance between the end of the flow and the earlier frame's feature that is its match.
  static constexpr double kMaxOffset_px = 2.0;

  static const FieldTable<DescriptorDistanceParams>& fields() {
    using P = DescriptorDistanceParams;
    static const FieldTable<P> table{
        integer("max_distance_bits", &P::max_distance_bits, "bits", {0, 65536},
                "largest Hamming distance of matched descriptors that counts as similar"),
    };
    return table;
  }
};

/// Marks matches with similar descriptors as candidates for movers (Zhou et al. sec. 3.1.2).
/// If a geometric filter rejects such a match, the cause is motion and not a mismatch.
/// Use it as a member of `all`. Alone, it votes every good match dynamic.
///
/// Formula:  Hamming distance <= max_distance_bits: dynamic, else static.
/// Needs:    descriptors, correspondences.
/// Abstains: without a match, and if descriptor lengths differ.
///           With flow: if the earlier frame has no feature at the end of the flow.
/// Blind to: everything except appearance.
/// State:    none; the pipeline keeps the last frame.
/// Cost:     about 0.03 ms for 1000 matches.
class DescriptorDistanceFilter final
    : public ParametricFilter<DescriptorDistanceFilter, DescriptorDistanceParams> {
 public:
  using ParametricFilter::ParametricFilter;
  static constexpr const char* kName = "descriptor_distance";
  static constexpr const char* kSummary =
      "features whose match has a similar descriptor; for use inside `all`, with a geometric filter";

  Needs needs() const override { return {Input::Descriptors | Input::Correspondence, Input::None, 1}; }

  void apply(const Evidence& evidence, Votes& votes) override;

 private:
};

inline void DescriptorDistanceFilter::apply(const Evidence& evidence, Votes& votes) {
  const Match& match = evidence.match({});
  if (match.reference == nullptr) return votes.note("no earlier frame");
  const MatchedFeatures& matched = evidence.matched_features(match, Params::kMaxOffset_px);
  if (!matched.has_descriptors()) return votes.note("the earlier frame has no descriptors like these");
  for (std::size_t i = 0; i < evidence.size(); ++i) {
    const std::int32_t bits = matched.distance_bits(i);
    if (!evidence.judged(i) || bits < 0) continue;
    const float missed = 1 - suspicion(bits, params_.max_distance_bits);
    votes.cast(i, bits <= params_.max_distance_bits ? Vote::Dynamic : Vote::Static, missed);
  }
}

}  // namespace dynfilter
