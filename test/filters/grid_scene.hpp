// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <dynfilter/core/filter.hpp>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/needs.hpp>
#include <dynfilter/core/span.hpp>
#include <dynfilter/core/verdict.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/evidence/evidence.hpp>
#include <dynfilter/evidence/frame_evidence.hpp>
#include <utility>
#include <vector>

/// A 9 x 9 grid of features, 10 px apart from (10, 10), and the boxes of one frame.
struct GridScene {
  GridScene() {
    for (int y = 10; y < 100; y += 10)
      for (int x = 10; x < 100; x += 10)
        keypoints.emplace_back(static_cast<float>(x), static_cast<float>(y), 1.0F);
  }
  static dynfilter::Detection detection(float x, float y, float w, float h, const char* name = "person",
                                        float score = 0.9F) {
    dynfilter::Detection d;
    d.box = {x, y, w, h};
    d.class_name = name;
    d.score = score;
    return d;
  }
  dynfilter::FrameView view(std::int64_t id = 0) const {
    dynfilter::FrameView frame;
    frame.id = id;
    frame.keypoints = keypoints;
    frame.detections = dynfilter::DetectionInput{-1, boxes};
    return frame;
  }
  std::size_t at(int x, int y) const { return static_cast<std::size_t>((y / 10 - 1) * 9 + x / 10 - 1); }
  /// Matches of every feature with itself.
  static std::vector<std::int32_t> same() {
    std::vector<std::int32_t> index(81);
    for (int i = 0; i < 81; ++i) index[static_cast<std::size_t>(i)] = i;
    return index;
  }

  std::vector<cv::KeyPoint> keypoints;
  std::vector<dynfilter::Detection> boxes;
};

/// Runs one filter on one frame like a pipeline.
inline dynfilter::Votes votes_of(dynfilter::Filter& filter, dynfilter::FrameEvidence& evidence,
                                 const dynfilter::FrameView& frame) {
  dynfilter::Votes votes;
  votes.reset(frame.size());
  evidence.begin(frame, dynfilter::CallPoint::BeforePose);
  if (dynfilter::without(filter.needs().required, evidence.inputs()) == dynfilter::Input::None)
    filter.apply(evidence, votes);
  return votes;
}
