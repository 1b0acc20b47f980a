// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/evidence/current_frame.hpp>
#include <dynfilter/evidence/feature_tracks.hpp>
#include <dynfilter/evidence/frame_matches.hpp>
#include <list>
#include <vector>

namespace dynfilter {

/// The features' tracks, chained once per frame for each set of options.
class FrameTracks {
 public:
  FrameTracks(CurrentFrame& current, FrameMatches& matches) : current_(current), matches_(matches) {}

  const FeatureTracks& tracks(const TrackOptions& options) {
    FeatureTracks& tracks = with(options);
    if (tracks.last_id() == current_.frame().id && tracks.size() == current_.size()) return tracks;
    static const std::vector<float> kNoDepths;
    tracks.follow(current_.frame().id, matches_.match({}), current_.pixels(), current_.undistorted_pixels(),
                  options.use_depth ? current_.depths_m() : kNoDepths);
    return tracks;
  }
  void reset() {
    for (FeatureTracks& tracks : all_) tracks.reset();
  }

 private:
  FeatureTracks& with(const TrackOptions& options) {
    for (FeatureTracks& tracks : all_)
      if (tracks.options() == options) return tracks;
    all_.emplace_back(options);
    return all_.back();
  }

  CurrentFrame& current_;
  FrameMatches& matches_;
  std::list<FeatureTracks> all_;  ///< a list, because filters hold references
};

}  // namespace dynfilter
