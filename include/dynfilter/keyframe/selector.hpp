// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <dynfilter/keyframe/frame_summary.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace dynfilter {

/// Selects the frames that a map is built from. Frames are added one by one. Keyframes are returned in id
/// order, possibly later and in batches. Use one object per camera stream. Deterministic.
///
///     for (const FrameSummary& frame : stream)
///       for (const SelectedFrame& key : selector.add(frame)) map(key.id);
///     for (const SelectedFrame& key : selector.flush()) map(key.id);
class KeyframeSelector {
 public:
  /// Counts of unusable frames that were skipped.
  struct LeftOut {
    std::size_t bad_pose = 0;   ///< not rigid or not finite
    std::size_t not_newer = 0;  ///< id or timestamp not larger than before
  };

  virtual ~KeyframeSelector() = default;
  virtual std::string name() const = 0;  ///< its name in YAML

  /// Returns the keyframes that this frame decides, possibly none.
  std::vector<SelectedFrame> add(const FrameSummary& frame);

  /// Call at the end of the stream. Decides all pending frames.
  virtual std::vector<SelectedFrame> flush() { return {}; }
  /// Ids of frames that may still become keyframes, ascending. The mapper must keep these frames.
  virtual std::vector<std::int64_t> pending() const { return {}; }
  /// Clears all state.
  void reset() {
    left_out_ = LeftOut();
    newest_.reset();
    forget();
  }
  const LeftOut& left_out() const { return left_out_; }  ///< counts since the last reset

 protected:
  /// The keyframes that a usable frame decides.
  virtual std::vector<SelectedFrame> choose(const FrameSummary& frame) = 0;
  virtual void forget() = 0;  ///< clears the state of the derived class

 private:
  bool newer(const FrameSummary& frame) const {
    return frame.id > newest_->first && frame.timestamp_s > newest_->second;
  }

  LeftOut left_out_;
  std::optional<std::pair<std::int64_t, double>> newest_;
};

inline std::vector<SelectedFrame> KeyframeSelector::add(const FrameSummary& frame) {
  if (!is_rigid(frame.T_world_camera)) return ++left_out_.bad_pose, std::vector<SelectedFrame>();
  if (!std::isfinite(frame.timestamp_s) || (newest_ && !newer(frame)))
    return ++left_out_.not_newer, std::vector<SelectedFrame>();
  newest_ = std::make_pair(frame.id, frame.timestamp_s);
  return choose(frame);
}

}  // namespace dynfilter
