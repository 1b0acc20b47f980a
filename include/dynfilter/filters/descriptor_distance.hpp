// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/filter.hpp>
#include <dynfilter/core/needs.hpp>
#include <dynfilter/config/parameters.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/evidence/evidence.hpp>
#include <string>

namespace dynfilter {

struct DescriptorDistanceParams {
  int max_distance_bits = 50;
  double max_offset_px = 2.0;
  bool keyframe = false;
  int gap_frames = 1;

  static const FieldTable<DescriptorDistanceParams>& fields();
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
/// State:    none; the pipeline keeps gap_frames frames.
/// Cost:     about 0.03 ms for 1000 matches.
class DescriptorDistanceFilter final : public NamedFilter<DescriptorDistanceFilter> {
 public:
  using Params = DescriptorDistanceParams;
  static constexpr const char* kName = "descriptor_distance";
  static constexpr const char* kSummary =
      "features whose match has a similar descriptor; for use inside `all`, with a geometric filter";

  explicit DescriptorDistanceFilter(Params params = Params());

  Needs needs() const override {
    return {Input::Descriptors | Input::Correspondence, Input::None, params_.gap_frames};
  }

  void apply(const Evidence& evidence, Votes& votes) override;

 private:
  Params params_;
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/filters/detail/descriptor_distance-inl.hpp>
#endif
