// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>

#include "live_window.hpp"
#include "overlay.hpp"
#include "sequence_run.hpp"
#include "video_output.hpp"

namespace dynfilter::command {

/// The annotated frames of `--live` and `--video`.
class FrameShow {
 public:
  /// `paced`: the window plays at the pace of the stamps. Throws Error.
  FrameShow(const RunOptions& options, bool paced) {
    if (!options.video.empty()) video_.emplace(options.video, options.force);
    if (options.live) window_.emplace("dynfilter: " + options.sequence, paced);
  }

  bool wants_frames() const { return window_ || video_; }

  /// True if the frame is left out, because the window would come too late with it.
  bool drops(double next_s) { return window_ && window_->is_late(next_s); }
  std::size_t dropped() const { return window_ ? window_->dropped() : 0; }

  /// Returns false if the user wants to end. `rate_hz`: of the played frames.
  bool add(const cv::Mat& picture, double timestamp_s, double next_s, double rate_hz) {
    if (video_) video_->add(picture, rate_hz);
    return !window_ || window_->show(picture, timestamp_s, next_s);
  }

  /// The video appears.
  void commit() {
    if (video_) video_->commit();
  }

  static constexpr int kWidth_px = 1280;  ///< of the pictures at most

 private:
  std::optional<VideoOutput> video_;
  std::optional<LiveWindow> window_;
};

}  // namespace dynfilter::command
