// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/keyframe/selector.hpp>

#include <cmath>
#include <dynfilter/core/inline.hpp>
#include <dynfilter/core/pose.hpp>

namespace dynfilter {

DYNFILTER_INLINE std::vector<SelectedFrame> KeyframeSelector::add(const FrameSummary& frame) {
  if (!is_rigid(frame.T_world_camera)) return ++left_out_.bad_pose, std::vector<SelectedFrame>();
  if (!std::isfinite(frame.timestamp_s) || (newest_ && !newer(frame)))
    return ++left_out_.not_newer, std::vector<SelectedFrame>();
  newest_ = std::make_pair(frame.id, frame.timestamp_s);
  return choose(frame);
}

DYNFILTER_INLINE void KeyframeSelector::reset() {
  left_out_ = LeftOut();
  newest_.reset();
  forget();
}

}  // namespace dynfilter
