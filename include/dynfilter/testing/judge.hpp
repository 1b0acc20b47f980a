// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/filter.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/evidence/correspondence_params.hpp>
#include <dynfilter/testing/exact_scene.hpp>
#include <dynfilter/testing/exact_scene_frame.hpp>

namespace dynfilter::testing {

/// Runs a single filter over frames 0 to `frame` of a scene, like a pipeline.
/// Returns its votes on the last frame. Resets the filter first.
/// Throws ConfigError if the last frame lacks a required input.
/// A scene provides poses, boxes and other optional inputs only on request.
///
///   EpipolarFilter filter;
///   const ExactScene scene = preset(Preset::General).pixel_noise(0.3);
///   const Score score(judge(filter, scene, 8), scene.frame(8));
///   CHECK(score.recall() > 0.9);
///   CHECK(score.static_kept() > 0.9);
Votes judge(Filter& filter, const ExactScene& scene, int frame,
            const CorrespondenceParams& params = CorrespondenceParams());

/// Votes compared with the truth. DontCare features are not counted.
struct Score {
  int dynamic_count = 0, dynamic_found = 0;  ///< dynamic features; of these voted Dynamic
  int static_count = 0, static_lost = 0;     ///< static features; of these voted Dynamic
  int static_confirmed = 0;                  ///< static features voted Static
  /// Dynamic features voted Static, which is worse than Unknown.
  int dynamic_missed = 0;

  Score() = default;
  /// Throws ConfigError if the number of votes differs from the number of features.
  Score(const Votes& votes, const ExactFrame& frame);

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

}  // namespace dynfilter::testing

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/testing/detail/judge-inl.hpp>
#endif
