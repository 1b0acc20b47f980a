// SPDX-License-Identifier: MIT
#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <opencv2/core.hpp>
#include <opencv2/highgui.hpp>
#include <utility>

#include "media/media.hpp"

namespace dynfilter::media {
namespace {

class Window : public io::PictureWindow {
 public:
  explicit Window(std::string title) : title_(std::move(title)) {
    ::setenv("QT_LOGGING_RULES", "*.warning=false", 0);  // Qt's lines on stderr are no errors
    cv::namedWindow(title_, cv::WINDOW_NORMAL | cv::WINDOW_KEEPRATIO | cv::WINDOW_GUI_NORMAL);
  }
  ~Window() override {
    try {
      cv::destroyWindow(title_);
    } catch (const cv::Exception&) {  // the user closed it
    }
  }

  void show(const cv::Mat& picture) override { cv::imshow(title_, picture); }
  void resize(cv::Size size) override { cv::resizeWindow(title_, size.width, size.height); }
  int wait_ms(int ms) override { return cv::waitKeyEx(ms); }
  bool is_open() const override {
    try {
      return cv::getWindowProperty(title_, cv::WND_PROP_VISIBLE) >= 1;
    } catch (const cv::Exception&) {
      return false;
    }
  }

 private:
  std::string title_;
};

}  // namespace

std::unique_ptr<io::PictureWindow> make_window(const std::string& title) {
  return std::make_unique<Window>(title);
}

bool display_answers() {
  const pid_t child = ::fork();
  if (child == 0) {
    const int nowhere = ::open("/dev/null", O_WRONLY);
    ::dup2(nowhere, STDERR_FILENO);
    try {
      cv::namedWindow("dynfilter", cv::WINDOW_NORMAL);
    } catch (...) {
      std::_Exit(1);
    }
    std::_Exit(0);
  }
  int status = 0;
  return child > 0 && ::waitpid(child, &status, 0) == child && WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

}  // namespace dynfilter::media
