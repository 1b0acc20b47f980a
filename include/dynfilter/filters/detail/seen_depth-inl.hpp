// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/filters/detail/seen_depth.hpp>

#include <cmath>
#include <dynfilter/core/inline.hpp>

namespace dynfilter {

DYNFILTER_INLINE void SeenDepth::from(const PastFrame& frame) {
  camera_ = frame.camera.value_or(Camera());
  image_ = frame.depth;
  unit_m_ = static_cast<float>(frame.depth_unit_m);
  distorted_ = true;
  set_keypoints(image_.empty() ? Span<const cv::KeyPoint>(frame.keypoints) : Span<const cv::KeyPoint>(),
                frame.depth_m);
}

DYNFILTER_INLINE void SeenDepth::from(const KeyframeView& keyframe, const Camera& camera) {
  camera_ = camera;
  image_ = cv::Mat();
  distorted_ = false;
  set_keypoints(keyframe.keypoints_undistorted, keyframe.depth_m);
}

DYNFILTER_INLINE void SeenDepth::Tally::add(double deviation) {
  if (!std::isfinite(deviation)) return;
  ++known;
  agreeing += std::abs(deviation) <= limit ? 1 : 0;
  beyond += deviation > limit ? 1 : 0;
  if (std::abs(deviation) < std::abs(smallest)) smallest = deviation;
}

DYNFILTER_INLINE SeenThere SeenDepth::Tally::verdict(int wanted) const {
  if (agreeing > 0) return SeenThere::Surface;
  if (known < wanted) return SeenThere::Nothing;
  return beyond == known ? SeenThere::Beyond : SeenThere::Nearer;
}

inline void SeenDepth::set_keypoints(Span<const cv::KeyPoint> keypoints, Span<const float> depth_m) {
  keypoints_ = keypoints.size() == depth_m.size() ? keypoints : Span<const cv::KeyPoint>();
  keypoint_depth_m_ = depth_m;
  grid_.build(keypoints_, 2 * kKeypointRadiusPx);
}

}  // namespace dynfilter
