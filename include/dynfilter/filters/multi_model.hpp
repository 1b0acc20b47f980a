// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <dynfilter/core/filter.hpp>
#include <dynfilter/core/needs.hpp>
#include <dynfilter/config/parameters.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/correspondence/match.hpp>
#include <dynfilter/evidence/evidence.hpp>
#include <dynfilter/filters/detail/sequential_homographies.hpp>
#include <string>
#include <vector>

namespace dynfilter {

struct MultiModelParams {
  double chance = 0.003;
  int max_models = 20;
  int iterations = 500;
  int neighbours = 8;
  bool keyframe = false;
  int gap_frames = 1;

  static const FieldTable<MultiModelParams>& fields();
};

/// Rejects mismatches: matches that no surface explains, static or moving.
/// Uses sequential RANSAC with samples of neighbouring matches
/// (Vincent and Laganiere 2001 use it for planes).
///
/// Formula:  Homographies H_1, H_2, ... are fitted in turn to the unexplained matches.
///           The loop ends if wrong matches alone would be expected to support one more.
///           Dynamic if |p1 - H_k p2| > d for every k.
///           A match with a random end agrees within d with probability `chance`.
/// Needs:    correspondences.
/// Abstains: without correspondence, and if no homography has support.
/// Blind to: movers, by design; mismatches that agree with each other (repeated texture).
/// State:    none; the pipeline keeps gap_frames frames.
/// Cost:     about 3 ms for 300 matches, a third of them wrong.
class MultiModelFilter final : public NamedFilter<MultiModelFilter> {
 public:
  using Params = MultiModelParams;
  static constexpr const char* kName = "multi_model";
  static constexpr const char* kSummary = "mismatches: features whose match no homography explains";

  explicit MultiModelFilter(Params params = Params());

  Needs needs() const override { return {Input::Correspondence, Input::Camera, params_.gap_frames}; }

  void apply(const Evidence& evidence, Votes& votes) override;

 private:
  struct Entry {
    std::size_t feature;
    ImageMatch match;
  };

  static SequentialHomographiesOptions options(const Params& p);

  /// Sorts by position, so that the result does not depend on the features' order.
  void collect(const Evidence& evidence, const Match& match);

  Params params_;
  SequentialHomographies models_;
  std::vector<Entry> entries_;
  std::vector<ImageMatch> matches_;
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/filters/detail/multi_model-inl.hpp>
#endif
