// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cctype>
#include <chrono>
#include <cstdlib>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <opencv2/videoio/registry.hpp>
#include <utility>
#include <vector>

#include "media/media.hpp"

namespace dynfilter::media {
namespace {

bool is_number(const std::string& text) {
  constexpr std::size_t kMostDigits = 4;
  return !text.empty() && text.size() <= kMostDigits &&
         text.find_first_not_of("0123456789") == std::string::npos;
}

/// Neither OpenCV nor FFmpeg prints to stderr, which has one line for an error.
class Quiet {
 public:
  Quiet() : before_(cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT)) {
    ::setenv("OPENCV_FFMPEG_LOGLEVEL", "-8", 0);  // AV_LOG_QUIET, read when the first file is opened
  }
  Quiet(const Quiet&) = delete;
  Quiet& operator=(const Quiet&) = delete;
  ~Quiet() { cv::utils::logging::setLogLevel(before_); }

 private:
  cv::utils::logging::LogLevel before_;
};

/// FFmpeg alone, if there is one: other readers take a single image for a sequence of images.
int file_reader() {
  const std::vector<cv::VideoCaptureAPIs> readers = cv::videoio_registry::getStreamBackends();
  const bool has = std::find(readers.begin(), readers.end(), cv::CAP_FFMPEG) != readers.end();
  return has ? cv::CAP_FFMPEG : cv::CAP_ANY;
}

/// FFmpeg shows text files as pictures of a terminal.
bool is_terminal_art(const cv::VideoCapture& capture) {
  const auto code = static_cast<unsigned>(capture.get(cv::CAP_PROP_FOURCC));
  std::string name;
  for (unsigned shift = 0; shift < 32; shift += 8)
    name += static_cast<char>(std::tolower((code >> shift) & 0xFFU));
  return name == "ansi" || (code == 0 && capture.get(cv::CAP_PROP_FRAME_WIDTH) == 640 &&
                            capture.get(cv::CAP_PROP_FRAME_HEIGHT) == 400);
}

class Reader : public io::VideoReader {
 public:
  Reader(std::string address, bool camera) : address_(std::move(address)), camera_(camera) { open(); }

  void open() final {
    const Quiet quiet;
    if (camera_ && is_number(address_))
      capture_.open(std::stoi(address_), cv::CAP_ANY);
    else
      capture_.open(address_, camera_ ? static_cast<int>(cv::CAP_ANY) : file_reader());
    if (capture_.isOpened() && !camera_ && is_terminal_art(capture_)) capture_.release();
  }
  bool is_open() const override { return capture_.isOpened(); }

  std::size_t claimed_frames() const override {
    constexpr double kMost = 1e9;
    const double claimed = capture_.get(cv::CAP_PROP_FRAME_COUNT);
    return claimed >= 1 && claimed <= kMost ? static_cast<std::size_t>(claimed) : 0;
  }

  std::size_t count_packets() const override {
    const Quiet quiet;
    cv::VideoCapture packets;
    std::size_t count = 0;
    if (packets.open(address_, file_reader()) && packets.set(cv::CAP_PROP_FORMAT, -1))
      while (grab_next(packets)) ++count;
    return count;
  }

  double rate_hz() const override { return capture_.get(cv::CAP_PROP_FPS); }
  bool grab() override {
    const Quiet quiet;
    return camera_ ? capture_.grab() : grab_next(capture_);
  }
  cv::Mat retrieve() override {
    const Quiet quiet;
    cv::Mat image;
    if (!capture_.retrieve(image) || image.empty()) return {};
    if (image.channels() == 1) cv::cvtColor(image, image, cv::COLOR_GRAY2BGR);
    return image.type() == CV_8UC3 ? image.clone() : cv::Mat();  // the decoder writes over its own
  }
  double position_s() const override {
    if (!camera_) return capture_.get(cv::CAP_PROP_POS_MSEC) / 1000;
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - began_).count();
  }

 private:
  // A packet that cannot be decoded ends one call, not the file.
  static bool grab_next(cv::VideoCapture& capture) {
    constexpr int kMostBroken = 100;  // one after another
    for (int tries = 0; tries < kMostBroken; ++tries)
      if (capture.grab()) return true;
    return false;
  }

  std::string address_;
  bool camera_;
  cv::VideoCapture capture_;
  std::chrono::steady_clock::time_point began_ = std::chrono::steady_clock::now();
};

class Writer : public io::VideoWriter {
 public:
  bool open(const std::filesystem::path& file, std::string_view codec, double rate_hz,
            cv::Size size) override {
    const Quiet quiet;
    const int code = cv::VideoWriter::fourcc(codec[0], codec[1], codec[2], codec[3]);
    return writer_.open(file.string(), cv::CAP_ANY, code, rate_hz, size);
  }
  void write(const cv::Mat& picture) override { writer_.write(picture); }
  void close() override { writer_.release(); }

 private:
  cv::VideoWriter writer_;
};

}  // namespace

std::unique_ptr<io::VideoReader> make_reader(const std::string& address, bool camera) {
  return std::make_unique<Reader>(address, camera);
}

std::unique_ptr<io::VideoWriter> make_writer() {
  return std::make_unique<Writer>();
}

}  // namespace dynfilter::media
