// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/evidence/current_frame.hpp>
#include <dynfilter/evidence/feature_tracks.hpp>
#include <dynfilter/evidence/frame_matches.hpp>
#include <list>

namespace dynfilter {

/// The features' tracks, chained once per frame for each set of options.
class FrameTracks {
 public:
  FrameTracks(CurrentFrame& current, FrameMatches& matches) : current_(current), matches_(matches) {}

  const FeatureTracks& tracks(const TrackOptions& options);
  void reset();

 private:
  FeatureTracks& with(const TrackOptions& options);

  CurrentFrame& current_;
  FrameMatches& matches_;
  std::list<FeatureTracks> all_;  ///< a list, because filters hold references
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/evidence/detail/frame_tracks-inl.hpp>
#endif
