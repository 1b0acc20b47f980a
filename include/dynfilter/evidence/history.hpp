// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <dynfilter/correspondence/image_pyramid.hpp>
#include <dynfilter/correspondence/match.hpp>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <utility>
#include <vector>

namespace dynfilter {

/// A past frame with the image pyramid that flow is tracked on.
struct StoredFrame : PastFrame {
  ImagePyramid pyramid;   ///< empty unless flow is used
  cv::Mat right_grey;     ///< of a stereo camera, or empty
  int left_brighter = 0;  ///< RowSearch::left_brighter() of the two images
};

/// The last frames of one camera stream, and the last keyframe.
/// Slots are reused, so the steady state allocates nothing that scales with the image.
class History {
 public:
  /// Sets how many earlier frames to keep in addition to the last keyframe.
  void set_capacity(int frames) { capacity_ = frames < 1 ? 1 : static_cast<std::size_t>(frames); }

  void clear();

  /// The slot of the frame being judged. Call it with each view; a new id starts a new slot.
  StoredFrame& current(std::int64_t id);

  /// The frame `gap` frames before the current one, or the oldest one kept. Null without an earlier frame.
  const StoredFrame* before(int gap) const;
  StoredFrame* find(std::int64_t id) const;  ///< null: the frame is not kept
  /// The last keyframe, unless it is the current frame.
  const StoredFrame* keyframe() const {
    return frames_.empty() || keyframe_ != frames_.back() ? keyframe_.get() : nullptr;
  }
  /// The frame that was added last. Null: none.
  const StoredFrame* newest() const { return frames_.empty() ? nullptr : frames_.back().get(); }
  void forget_poses();   ///< of all frames
  void mark_keyframe();  ///< the current frame is the last keyframe from now on
  std::size_t size() const { return frames_.size(); }

 private:
  using FramePtr = std::shared_ptr<StoredFrame>;

  /// Reuses a frame unless something else, such as the keyframe, still refers to it.
  void recycle(FramePtr frame) {
    if (frame && frame.use_count() == 1) spare_.push_back(std::move(frame));
  }
  FramePtr take_spare();

  std::size_t capacity_ = 1;
  std::vector<FramePtr> frames_;  ///< oldest first; the last one is the current frame
  std::vector<FramePtr> spare_;
  FramePtr keyframe_;
};

inline void History::clear() {
  for (FramePtr& frame : frames_) recycle(std::move(frame));
  frames_.clear();
  recycle(std::move(keyframe_));
}

inline StoredFrame& History::current(std::int64_t id) {
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

inline const StoredFrame* History::before(int gap) const {
  const auto n = static_cast<int>(frames_.size());
  if (n < 2 || gap < 1) return nullptr;
  return frames_[static_cast<std::size_t>(gap < n ? n - 1 - gap : 0)].get();
}

inline StoredFrame* History::find(std::int64_t id) const {
  for (const FramePtr& frame : frames_)
    if (frame->id == id) return frame.get();
  return keyframe_ && keyframe_->id == id ? keyframe_.get() : nullptr;
}

inline void History::mark_keyframe() {
  if (frames_.empty() || keyframe_ == frames_.back()) return;
  recycle(std::move(keyframe_));
  keyframe_ = frames_.back();
}

inline void History::forget_poses() {
  for (const FramePtr& frame : frames_) frame->pose_provenance = PoseProvenance::None;
  if (keyframe_) keyframe_->pose_provenance = PoseProvenance::None;
}

inline History::FramePtr History::take_spare() {
  if (spare_.empty()) return std::make_shared<StoredFrame>();
  FramePtr frame = std::move(spare_.back());
  spare_.pop_back();
  return frame;
}

}  // namespace dynfilter
