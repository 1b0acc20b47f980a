// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <dynfilter/core/error.hpp>
#include <dynfilter/core/filter.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/evidence/frame_evidence.hpp>
#include <dynfilter/testing/exact_scene.hpp>
#include <dynfilter/testing/exact_scene_frame.hpp>
#include <string>

namespace dynfilter::testing {

/// Votes compared with the truth. DontCare features are not counted.
struct Score {
  int dynamic_count = 0, dynamic_found = 0;  ///< dynamic features; of these voted Dynamic
  int static_count = 0, static_lost = 0;     ///< static features; of these voted Dynamic
  int static_confirmed = 0;                  ///< static features voted Static
  /// Dynamic features voted Static, which is worse than Unknown.
  int dynamic_missed = 0;

  Score() = default;
  /// Throws ConfigError if the number of votes differs from the number of features.
  Score(const Votes& votes, const ExactFrame& frame) { add(votes, frame); }

  /// Adds the counts of one more frame; throws as above.
  void add(const Votes& votes, const ExactFrame& frame);

  /// Share of the dynamic features that are voted Dynamic; 1 without any.
  double recall() const { return share(dynamic_found, dynamic_count); }
  /// Share of the features voted Dynamic that are dynamic; 1 without any.
  double precision() const { return share(dynamic_found, dynamic_found + static_lost); }
  /// Share of the static features that are not voted Dynamic; 1 without any.
  double static_kept() const { return share(static_count - static_lost, static_count); }

 private:
  static double share(int part, int of) { return of > 0 ? static_cast<double>(part) / of : 1; }
};

/// Runs a single filter over frames 0 to `frame` of a scene, like a pipeline. Returns its votes on the last
/// frame. Resets the filter first. Throws ConfigError if the last frame lacks a required input. A scene
/// provides poses, boxes and other optional inputs only on request.
///
///   EpipolarFilter filter;
///   const ExactScene scene = preset(Preset::General).pixel_noise(0.3);
///   const Score score(judge(filter, scene, 8), scene.frame(8));
///   CHECK(score.recall() > 0.9);
///   CHECK(score.static_kept() > 0.9);
inline Votes judge(Filter& filter, const ExactScene& scene, int frame,
                   const CorrespondenceParams& params = CorrespondenceParams()) {
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

inline void Score::add(const Votes& votes, const ExactFrame& frame) {
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
