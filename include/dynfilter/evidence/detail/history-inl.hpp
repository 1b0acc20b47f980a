// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/evidence/history.hpp>

#include <dynfilter/core/inline.hpp>
#include <dynfilter/core/pose.hpp>

namespace dynfilter {

DYNFILTER_INLINE void History::clear() {
  for (FramePtr& frame : frames_) recycle(std::move(frame));
  frames_.clear();
  recycle(std::move(keyframe_));
}

DYNFILTER_INLINE StoredFrame& History::current(std::int64_t id) {
  if (!frames_.empty() && frames_.back()->id == id) return *frames_.back();
  if (frames_.size() > capacity_) {
    recycle(std::move(frames_.front()));
    frames_.erase(frames_.begin());
  }
  frames_.push_back(take_spare());
  StoredFrame& frame = *frames_.back();
  frame.id = id;
  frame.pyramid.clear();
  frame.pose_provenance = PoseProvenance::None;
  return frame;
}

DYNFILTER_INLINE const StoredFrame* History::before(int gap) const {
  const auto n = static_cast<int>(frames_.size());
  if (n < 2 || gap < 1) return nullptr;
  return frames_[static_cast<std::size_t>(gap < n ? n - 1 - gap : 0)].get();
}

DYNFILTER_INLINE StoredFrame* History::find(std::int64_t id) const {
  for (const FramePtr& frame : frames_)
    if (frame->id == id) return frame.get();
  return keyframe_ && keyframe_->id == id ? keyframe_.get() : nullptr;
}

DYNFILTER_INLINE void History::mark_keyframe() {
  if (frames_.empty() || keyframe_ == frames_.back()) return;
  recycle(std::move(keyframe_));
  keyframe_ = frames_.back();
}

inline History::FramePtr History::take_spare() {
  if (spare_.empty()) return std::make_shared<StoredFrame>();
  FramePtr frame = std::move(spare_.back());
  spare_.pop_back();
  return frame;
}

}  // namespace dynfilter
