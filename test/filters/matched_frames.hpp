// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/filter.hpp>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/needs.hpp>
#include <dynfilter/core/verdict.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/evidence/frame_evidence.hpp>
#include <vector>

namespace matched_frames {

using namespace dynfilter;

/// Features matched with those of the same index of an earlier frame.
struct MatchedFrames {
  std::vector<cv::KeyPoint> then, now;
  std::vector<std::int32_t> index;
  cv::Mat then_descriptors, now_descriptors;
  std::vector<float> depth_m;
  Camera camera;
  cv::Mat grey;

  void add(const cv::Point2f& from, const cv::Point2f& to) {
    then.emplace_back(from, 1.0F);
    now.emplace_back(to, 1.0F);
    index.push_back(static_cast<std::int32_t>(index.size()));
  }
  FrameView view(bool current) const {
    FrameView frame;
    frame.id = current ? 1 : 0;
    frame.keypoints = current ? now : then;
    frame.descriptors = current ? now_descriptors : then_descriptors;
    if (camera.valid()) frame.camera = camera;
    frame.depth_m = depth_m;
    frame.grey = grey;
    if (current) frame.matches = HostMatches{0, index};
    return frame;
  }
};

inline Votes votes_of(Filter& filter, const MatchedFrames& frames) {
  FrameEvidence evidence;
  evidence.begin(frames.view(false), CallPoint::BeforePose);
  evidence.end(false);
  const FrameView now = frames.view(true);
  evidence.begin(now, CallPoint::BeforePose);
  Votes votes;
  votes.reset(now.size());
  if (without(filter.needs().required, evidence.inputs()) == Input::None) filter.apply(evidence, votes);
  return votes;
}

}  // namespace matched_frames
