// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/evidence/frame_tracks.hpp>

#include <dynfilter/core/inline.hpp>
#include <vector>

namespace dynfilter {

DYNFILTER_INLINE const FeatureTracks& FrameTracks::tracks(const TrackOptions& options) {
  FeatureTracks& tracks = with(options);
  if (tracks.last_id() == current_.frame().id && tracks.size() == current_.size()) return tracks;
  static const std::vector<float> kNoDepths;
  tracks.follow(current_.frame().id, matches_.match({}), current_.pixels(), current_.undistorted_pixels(),
                options.use_depth ? current_.depths_m() : kNoDepths);
  return tracks;
}

DYNFILTER_INLINE void FrameTracks::reset() {
  for (FeatureTracks& tracks : all_) tracks.reset();
}

inline FeatureTracks& FrameTracks::with(const TrackOptions& options) {
  for (FeatureTracks& tracks : all_)
    if (tracks.options() == options) return tracks;
  all_.emplace_back(options);
  return all_.back();
}

}  // namespace dynfilter
