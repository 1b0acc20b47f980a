// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/evidence/frame_tracks.hpp>

#include <dynfilter/core/inline.hpp>
#include <vector>

namespace dynfilter {

DYNFILTER_INLINE const FeatureTracks& FrameTracks::tracks(const TrackOptions& options, CallPoint call_point) {
  FeatureTracks& tracks = with(options, call_point);
  if (tracks.last_id() == current_.frame().id && tracks.size() == current_.size()) return tracks;
  static const std::vector<float> kNoDepths;
  tracks.follow(current_.frame().id, matches_.match({}), current_.pixels(), current_.undistorted_pixels(),
                options.use_depth ? current_.depths_m() : kNoDepths);
  return tracks;
}

DYNFILTER_INLINE void FrameTracks::reset() {
  for (Chain& chain : all_) chain.tracks.reset();
}

inline FeatureTracks& FrameTracks::with(const TrackOptions& options, CallPoint call_point) {
  for (Chain& chain : all_)
    if (chain.call_point == call_point && chain.tracks.options() == options) return chain.tracks;
  all_.push_back({call_point, FeatureTracks(options)});
  return all_.back().tracks;
}

}  // namespace dynfilter
