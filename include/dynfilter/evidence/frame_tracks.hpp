// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/verdict.hpp>
#include <dynfilter/evidence/current_frame.hpp>
#include <dynfilter/evidence/feature_tracks.hpp>
#include <dynfilter/evidence/frame_matches.hpp>
#include <list>

namespace dynfilter {

/// The features' tracks, chained once per frame for each set of options. Hosts compact the frame between call
/// points, so each call point has its own.
class FrameTracks {
 public:
  FrameTracks(CurrentFrame& current, FrameMatches& matches) : current_(current), matches_(matches) {}

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

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/evidence/detail/frame_tracks-inl.hpp>
#endif
