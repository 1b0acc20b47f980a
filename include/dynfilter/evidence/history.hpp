// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <dynfilter/correspondence/image_pyramid.hpp>
#include <dynfilter/correspondence/past_frame.hpp>
#include <memory>
#include <utility>
#include <vector>

namespace dynfilter {

/// A past frame with the image pyramid that flow is tracked on.
struct StoredFrame : PastFrame {
  ImagePyramid pyramid;  ///< empty unless flow is used
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

  /// The frame `gap` frames before the current one, or the oldest one kept.
  /// Null without an earlier frame.
  const StoredFrame* before(int gap) const;
  StoredFrame* find(std::int64_t id) const;
  /// The last keyframe, unless it is the current frame.
  const StoredFrame* keyframe() const {
    return frames_.empty() || keyframe_ != frames_.back() ? keyframe_.get() : nullptr;
  }
  void mark_keyframe();
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

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/evidence/detail/history-inl.hpp>
#endif
