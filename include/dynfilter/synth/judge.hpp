// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <dynfilter/context/context.hpp>
#include <dynfilter/core/error.hpp>
#include <dynfilter/core/filter.hpp>
#include <dynfilter/synth/exact_scene.hpp>
#include <string>

namespace dynfilter::synth {

/// Runs a filter alone over frames 0 to `frame` of a scene, as a pipeline would, and returns its votes on the
/// last one. The filter is reset first. Throws ConfigError when the last frame lacks an input the filter
/// needs: a scene hands over poses, boxes, ... only when asked to.
///
///   EpipolarFilter filter;
///   const ExactScene scene = preset(Preset::General).pixel_noise(0.3);
///   const Score score(judge(filter, scene, 8), scene.frame(8));
///   CHECK(score.recall() > 0.9);
///   CHECK(score.static_kept() > 0.9);
inline Votes judge(Filter& filter, const ExactScene& scene, int frame,
                   const ContextParams& params = ContextParams()) {
  const Needs needs = filter.needs();
  Context context(params);
  context.set_history(std::max(needs.history_frames, scene.gap()));
  filter.reset();
  Votes votes;
  for (int k = 0; k <= frame; ++k) {
    const ExactFrame now = scene.frame(k);  // lives as long as the context looks at its view
    context.begin(now.view(), CallPoint::BeforePose);
    votes.reset(now.size());
    const Input missing = without(needs.required, context.inputs());
    if (missing == Input::None)
      filter.apply(context, votes);
    else if (k == frame)
      throw ConfigError(filter.name(),
                        "frame " + std::to_string(k) + " of the scene has no " + to_string(missing));
    context.finish(false);
  }
  return votes;
}

/// Votes held against the truth. What the truth does not care about is not counted.
struct Score {
  int dynamic_count = 0, dynamic_found = 0;  ///< truly dynamic; of these voted Dynamic
  int static_count = 0, static_lost = 0;     ///< truly static; of these voted Dynamic
  int static_confirmed = 0;                  ///< truly static and voted Static
  int dynamic_missed = 0;                    ///< truly dynamic and voted Static: worse than Unknown

  Score() = default;
  /// Throws ConfigError when the votes are not about this frame's features.
  Score(const Votes& votes, const ExactFrame& frame) { add(votes, frame); }

  void add(const Votes& votes, const ExactFrame& frame) {
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

  /// Share of the dynamic features that were found; 1 where there are none.
  double recall() const { return share(dynamic_found, dynamic_count); }
  /// Share of the features voted Dynamic that are; 1 where none was.
  double precision() const { return share(dynamic_found, dynamic_found + static_lost); }
  /// Share of the static features that were not voted Dynamic; 1 where there are none.
  double static_kept() const { return share(static_count - static_lost, static_count); }

 private:
  static double share(int part, int of) { return of > 0 ? static_cast<double>(part) / of : 1; }
};

}  // namespace dynfilter::synth
