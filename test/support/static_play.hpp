// SPDX-License-Identifier: MIT
// Recordings in which nothing moves but the camera, played to and fro: whatever a pipeline rejects is a
// mistake.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/verdict.hpp>
#include <dynfilter/pipeline/pipeline.hpp>
#include <opencv2/core.hpp>
#include <utility>
#include <vector>

#include "support/quadtree_features.hpp"

namespace dynfilter_test {

/// Images of one camera, and features of them.
struct GreyRecording {
  dynfilter::Camera camera;
  std::vector<double> times_s;
  std::vector<cv::Mat> images;
  std::vector<std::vector<cv::KeyPoint>> features;

  void spread_features(int count) {
    features.clear();
    for (const cv::Mat& image : images) features.push_back(quadtree_features(image, count));
  }
};

/// Shares of the features that are rejected [0 to 1].
struct Rejected {
  double mean = 0;   ///< of the frames
  double worst = 0;  ///< of one frame
  double late = 0;   ///< mean of the last second: a filter that has locked does not recover
};

/// Plays the recording from `first`, forwards or backwards, and to and fro until `frames` frames were judged.
/// Ids and stamps increase; the time between two frames is that of the recording.
inline Rejected play(dynfilter::Pipeline& pipeline, const GreyRecording& recording, std::size_t first,
                     bool backwards, int frames) {
  constexpr double kLate_s = 1;
  pipeline.reset();
  const auto last = static_cast<std::ptrdiff_t>(recording.images.size()) - 1;
  auto at = static_cast<std::ptrdiff_t>(first);
  if (backwards) at = last - at;
  std::ptrdiff_t step = backwards ? -1 : 1;
  double time_s = recording.times_s.front();
  std::vector<std::pair<double, double>> shares;  // time, share rejected
  for (int id = 0; id < frames; ++id) {
    const auto k = static_cast<std::size_t>(at);
    dynfilter::FrameView view;
    view.id = id;
    view.timestamp_s = time_s;
    view.keypoints = recording.features[k];
    view.grey = recording.images[k];
    view.camera = recording.camera;
    const dynfilter::Verdict& verdict = pipeline.before_pose(view);
    double rejected = 0;
    for (std::size_t i = 0; i < verdict.size(); ++i) rejected += verdict.keep(i) ? 0 : 1;
    shares.emplace_back(time_s, rejected / std::max(1.0, static_cast<double>(verdict.size())));
    if (at + step < 0 || at + step > last) step = -step;
    at += step;
    time_s += std::abs(recording.times_s[static_cast<std::size_t>(at)] - recording.times_s[k]);
  }
  Rejected rejected;
  double late_frames = 0;
  for (const auto& [stamp_s, share] : shares) {
    rejected.mean += share / static_cast<double>(shares.size());
    rejected.worst = std::max(rejected.worst, share);
    if (stamp_s < shares.back().first - kLate_s) continue;
    rejected.late += share, ++late_frames;
  }
  rejected.late /= late_frames;
  return rejected;
}

}  // namespace dynfilter_test
