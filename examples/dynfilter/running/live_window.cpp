// SPDX-License-Identifier: MIT
#include "live_window.hpp"

#include <algorithm>
#include <cstdlib>
#include <dynfilter/core/error.hpp>
#include <utility>

#include "interruption.hpp"

namespace dynfilter::command {
namespace {

constexpr std::size_t kStepsBack = 30;  // pictures in memory, about 4 MB each
constexpr int kPaused_ms = 40;          // how often a paused window looks at its state

bool has_display() {
#ifdef __APPLE__
  return true;
#else
  const auto is_set = [](const char* name) {
    const char* value = std::getenv(name);
    return value != nullptr && *value != '\0';
  };
  return is_set("DISPLAY") || is_set("WAYLAND_DISPLAY");
#endif
}

}  // namespace

LiveWindow::Key LiveWindow::key_of(int code) {
  constexpr int kEscape = 27, kLeftX11 = 0xFF51, kRightX11 = 0xFF53, kLeftQt = 0x51, kRightQt = 0x53;
  if (code < 0) return Key::None;
  const int key = code & 0xFFFF;
  if (key == kLeftX11 || key == kLeftQt) return Key::Back;
  if (key == kRightX11 || key == kRightQt) return Key::On;
  if (key == ' ') return Key::Pause;
  if (key == 'q' || key == kEscape) return Key::End;
  return Key::None;
}

LiveWindow::LiveWindow(const std::string& title, bool paced) : paced_(paced) {
  const std::string instead = "; without a window, --video FILE.mp4 writes what it would show";
  try {
    const io::Media& media = io::media();
    if (media.window == nullptr) throw io::NoMedia("it was built without OpenCV's highgui");
    if (!has_display())
      throw Error("--live: there is no display (DISPLAY and WAYLAND_DISPLAY are not set)" + instead);
    if (!media.display_answers())
      throw Error("--live: the display does not let a window be opened" + instead);
    window_ = media.window(title);
  } catch (const io::NoMedia& missing) {
    throw Error(std::string("--live: this build opens no window: ") + missing.what() + instead);
  }
}

LiveWindow::Key LiveWindow::wait(int ms) const {
  const Key key = key_of(window_->wait_ms(std::max(1, ms)));
  Interruption::check();
  return window_->is_open() ? key : Key::End;
}

int LiveWindow::ms_until(double timestamp_s) const {
  const std::chrono::duration<double> since_begin(timestamp_s);
  const auto due = *began_ + std::chrono::duration_cast<Clock::duration>(since_begin);
  return static_cast<int>(std::chrono::duration_cast<std::chrono::milliseconds>(due - Clock::now()).count());
}

bool LiveWindow::is_late(double next_s) {
  if (!paced_ || paused_ || !began_ || ms_until(next_s) >= 0) return false;
  ++dropped_;
  return true;
}

bool LiveWindow::show(const cv::Mat& picture, double timestamp_s, double next_s) {
  if (!began_)
    began_ = Clock::now() -
             std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(timestamp_s));
  if (last_.empty()) window_->resize(picture.size());
  last_.push_back(picture);
  if (last_.size() > kStepsBack) last_.pop_front();
  window_->show(picture);
  if (paused_) return hold(Key::None);
  do {
    const Key key = wait(paced_ ? ms_until(next_s) : 1);
    if (key == Key::End) return false;
    if (key != Key::None) return hold(key);
  } while (paced_ && ms_until(next_s) > 0);
  return true;
}

// Until the user steps to the next frame or goes on. The pause does not count as time of the source.
bool LiveWindow::hold(Key first) {
  const auto paused_at = Clock::now();
  std::size_t shown = last_.size() - 1;
  paused_ = true;
  if (first == Key::Back && shown > 0) window_->show(last_[--shown]);
  while (true) {
    const Key key = wait(kPaused_ms);
    if (key == Key::End) return false;
    if (key == Key::Pause) paused_ = false;
    if (key == Key::Pause || (key == Key::On && shown + 1 == last_.size())) break;
    if (key == Key::Back && shown > 0) window_->show(last_[--shown]);
    if (key == Key::On) window_->show(last_[++shown]);
  }
  *began_ += Clock::now() - paused_at;
  return true;
}

}  // namespace dynfilter::command
