// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cstddef>
#include <deque>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>

#include "io/media.hpp"

namespace dynfilter::command {

/// The window of `--live`. Space pauses, arrows step, q or Esc ends, as does closing the window.
class LiveWindow {
 public:
  /// Throws Error without a display, or if dynfilter was built without OpenCV's highgui.
  LiveWindow(const std::string& title, bool paced);
  LiveWindow(const LiveWindow&) = delete;
  LiveWindow& operator=(const LiveWindow&) = delete;

  /// True if the frame after it is due already: this one is dropped to keep the pace.
  bool is_late(double next_s);

  /// Shows a picture until the next frame is due. False if the user wants to end.
  bool show(const cv::Mat& picture, double timestamp_s, double next_s);

  std::size_t dropped() const { return dropped_; }

 private:
  using Clock = std::chrono::steady_clock;
  enum class Key { None, Pause, Back, On, End };

  static Key key_of(int code);
  Key wait(int ms) const;
  int ms_until(double timestamp_s) const;
  bool hold(Key first);

  std::unique_ptr<io::PictureWindow> window_;
  bool paced_;  ///< a file plays at its own pace; a camera sets it itself
  bool paused_ = false;
  std::size_t dropped_ = 0;
  std::optional<Clock::time_point> began_;  ///< when time 0 of the source was
  std::deque<cv::Mat> last_;                ///< pictures to step back to
};

}  // namespace dynfilter::command
