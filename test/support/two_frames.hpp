// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <dynfilter/evidence/frame_evidence.hpp>
#include <dynfilter/filters/background_motion.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "eval/classification.hpp"
#include "render/sequence_renderer.hpp"

namespace two_frames {

constexpr double kRate_hz = 30;

/// Options for pairs that are `gap` frames apart: dynamic is what moved more than 10 mm and 1 px in between.
inline dynfilter::render::SequenceOptions options(const std::string& scene, std::uint64_t seed, int gap) {
  dynfilter::render::SequenceOptions options;
  options.scene = scene;
  options.seed = seed;
  options.rate_hz = kRate_hz;
  options.truth.window_s = gap / kRate_hz;
  return options;
}

/// The spread corners of an image. At most 1000.
inline std::vector<cv::KeyPoint> corners(const cv::Mat& grey) {
  std::vector<cv::Point2f> places;
  cv::goodFeaturesToTrack(grey, places, 1000, 0.005, 7);
  std::vector<cv::KeyPoint> keypoints;
  for (const cv::Point2f& place : places) keypoints.emplace_back(place, 7.0F);
  return keypoints;
}

/// What the default filter says of the frame `first + gap` if it has seen only the frame `first` before.
inline dynfilter::eval::Classification judge(dynfilter::render::SequenceRenderer& renderer, int first,
                                             int gap) {
  using namespace dynfilter;
  BackgroundMotionFilter filter;
  FrameEvidence evidence;
  evidence.set_history(filter.needs().history_frames);
  Votes votes;
  eval::Classification counts;
  for (const int index : {first, first + gap}) {
    const render::RenderedFrame frame = renderer.frame(index);
    cv::Mat grey;
    cv::cvtColor(frame.colour, grey, cv::COLOR_BGR2GRAY);
    const std::vector<cv::KeyPoint> keypoints = corners(grey);
    FrameView view;
    view.id = index;
    view.timestamp_s = frame.timestamp_s;
    view.keypoints = keypoints;
    view.grey = grey;
    view.depth = frame.depth;
    view.depth_unit_m = 1 / render::kDepthUnitsPerM;
    view.camera = renderer.calibration();
    evidence.begin(view, CallPoint::BeforePose);
    votes.reset(view.size());
    filter.apply(evidence, votes);
    evidence.end(false);
    if (index == first) continue;
    for (std::size_t i = 0; i < keypoints.size(); ++i)
      counts.add(eval::truth_at(frame.truth.dynamic, keypoints[i].pt), votes[i] == Vote::Dynamic);
  }
  return counts;
}

}  // namespace two_frames
