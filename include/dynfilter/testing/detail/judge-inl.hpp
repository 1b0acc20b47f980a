// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/testing/judge.hpp>

#include <algorithm>
#include <cstddef>
#include <dynfilter/core/error.hpp>
#include <dynfilter/core/inline.hpp>
#include <dynfilter/core/needs.hpp>
#include <dynfilter/core/verdict.hpp>
#include <dynfilter/evidence/frame_evidence.hpp>
#include <string>

namespace dynfilter::testing {

DYNFILTER_INLINE Votes judge(Filter& filter, const ExactScene& scene, int frame,
                             const CorrespondenceParams& params) {
  const Needs needs = filter.needs();
  FrameEvidence evidence(params);
  evidence.set_history(std::max(needs.history_frames, scene.gap()));
  filter.reset();
  Votes votes;
  for (int k = 0; k <= frame; ++k) {
    const ExactFrame now = scene.frame(k);  // must outlive the use of its view
    evidence.begin(now.view(), CallPoint::BeforePose);
    votes.reset(now.size());
    const Input missing = without(needs.required, inputs_of(now.view()));
    if (without(needs.required, evidence.inputs()) == Input::None)
      filter.apply(evidence, votes);
    else if (k == frame && missing != Input::None)  // else it has no valid value: a pipeline skips the stage
      throw ConfigError(filter.name(),
                        "frame " + std::to_string(k) + " of the scene has no " + to_string(missing));
    evidence.end(false);
  }
  return votes;
}

DYNFILTER_INLINE Score::Score(const Votes& votes, const ExactFrame& frame) {
  add(votes, frame);
}

DYNFILTER_INLINE void Score::add(const Votes& votes, const ExactFrame& frame) {
  if (votes.size() != frame.size())
    throw ConfigError(
        "", std::to_string(votes.size()) + " votes for " + std::to_string(frame.size()) + " features");
  for (std::size_t i = 0; i < votes.size(); ++i) {
    if (frame.truth[i] == Truth::Dynamic) {
      ++dynamic_count;
      dynamic_found += votes[i] == Vote::Dynamic ? 1 : 0;
      dynamic_missed += votes[i] == Vote::Static ? 1 : 0;
    } else if (frame.truth[i] == Truth::Static) {
      ++static_count;
      static_lost += votes[i] == Vote::Dynamic ? 1 : 0;
      static_confirmed += votes[i] == Vote::Static ? 1 : 0;
    }
  }
}

}  // namespace dynfilter::testing
