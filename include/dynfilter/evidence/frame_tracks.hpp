// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/verdict.hpp>
#include <dynfilter/evidence/current_frame.hpp>
#include <dynfilter/evidence/feature_tracks.hpp>
#include <dynfilter/evidence/frame_matches.hpp>
#include <list>
#include <vector>

namespace dynfilter {

/// The features' tracks, chained once per frame for each set of options. Hosts compact the frame between call
/// points, so each call point has its own.
class FrameTracks {
 public:
  /// Refers to both, which must outlive it.
  FrameTracks(CurrentFrame& current, FrameMatches& matches) : current_(current), matches_(matches) {}

  /// See Evidence::tracks(); extends them once per frame.
  const FeatureTracks& tracks(const TrackOptions& options, CallPoint call_point);
  void reset();

 private:
  struct Chain {
    CallPoint call_point;
    FeatureTracks tracks;
  };
  FeatureTracks& with(const TrackOptions& options, CallPoint call_point);

  CurrentFrame& current_;
  FrameMatches& matches_;
  std::list<Chain> all_;  ///< a list, because filters hold references
};

inline const FeatureTracks& FrameTracks::tracks(const TrackOptions& options, CallPoint call_point) {
  FeatureTracks& tracks = with(options, call_point);
  if (tracks.last_id() == current_.frame().id && tracks.size() == current_.size()) return tracks;
  static const std::vector<float> kNoDepths;
  tracks.follow(current_.frame().id, matches_.match({}), current_.pixels(), current_.undistorted_pixels(),
                options.use_depth ? current_.depths_m() : kNoDepths);
  return tracks;
}

inline void FrameTracks::reset() {
  for (Chain& chain : all_) chain.tracks.reset();
}

inline FeatureTracks& FrameTracks::with(const TrackOptions& options, CallPoint call_point) {
  for (Chain& chain : all_)
    if (chain.call_point == call_point && chain.tracks.options() == options) return chain.tracks;
  all_.push_back({call_point, FeatureTracks(options)});
  return all_.back().tracks;
}

}  // namespace dynfilter
