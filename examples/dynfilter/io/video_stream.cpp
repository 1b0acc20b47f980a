// SPDX-License-Identifier: MIT
#include "io/video_stream.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <dynfilter/core/error.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>

#ifdef DYNFILTER_HAS_VIDEOIO
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/videoio.hpp>
#include <opencv2/videoio/registry.hpp>
#endif

namespace dynfilter::io {
namespace {

constexpr double kUsualRate_hz = 30;
constexpr double kLeastRate_hz = 0.1, kMostRate_hz = 1000;  // others are a container's nonsense
constexpr std::size_t kCameraFrames = 1'000'000;            // nine hours at 30 Hz

}  // namespace

#ifdef DYNFILTER_HAS_VIDEOIO

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

}  // namespace

class VideoStream::Decoder {
 public:
  Decoder(std::string address, bool camera) : address_(std::move(address)), camera_(camera) { open(); }

  void open() {
    const Quiet quiet;
    if (camera_ && is_number(address_))
      capture_.open(std::stoi(address_), cv::CAP_ANY);
    else
      capture_.open(address_, camera_ ? static_cast<int>(cv::CAP_ANY) : file_reader());
    if (capture_.isOpened() && !camera_ && is_terminal_art(capture_)) capture_.release();
  }
  bool is_open() const { return capture_.isOpened(); }

  /// What the header counts, which is an estimate in some containers.
  std::size_t claimed_frames() const {
    constexpr double kMost = 1e9;
    const double claimed = capture_.get(cv::CAP_PROP_FRAME_COUNT);
    return claimed >= 1 && claimed <= kMost ? static_cast<std::size_t>(claimed) : 0;
  }

  /// Counts the packets of a file, without decoding them.
  std::size_t count_packets() const {
    const Quiet quiet;
    cv::VideoCapture packets;
    std::size_t count = 0;
    if (packets.open(address_, file_reader()) && packets.set(cv::CAP_PROP_FORMAT, -1))
      while (grab_next(packets)) ++count;
    return count;
  }

  double rate_hz() const { return capture_.get(cv::CAP_PROP_FPS); }
  bool grab() {
    const Quiet quiet;
    return camera_ ? capture_.grab() : grab_next(capture_);
  }
  cv::Mat retrieve() {
    const Quiet quiet;
    cv::Mat image;
    if (!capture_.retrieve(image) || image.empty()) return {};
    if (image.channels() == 1) cv::cvtColor(image, image, cv::COLOR_GRAY2BGR);
    return image.type() == CV_8UC3 ? image.clone() : cv::Mat();  // the decoder writes over its own
  }
  double position_s() {
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

bool VideoStream::built_in() {
  return true;
}

#else

class VideoStream::Decoder {
 public:
  Decoder(const std::string&, bool) {}
  void open() {}
  bool is_open() const { return false; }
  std::size_t claimed_frames() const { return 0; }
  std::size_t count_packets() const { return 0; }
  double rate_hz() const { return 0; }
  bool grab() { return false; }
  cv::Mat retrieve() { return {}; }
  double position_s() { return 0; }
};

bool VideoStream::built_in() {
  return false;
}

#endif

std::string VideoStream::accepted() {
  return "accepted are a folder, a video file (mp4, mov, mkv, webm, avi, ...), camera:0 and 'frames/*.png'";
}

VideoStream::VideoStream(std::string name, bool camera) : name_(std::move(name)), camera_(camera) {
  if (!built_in())
    throw IoError(name_ +
                  ": this build reads no video: it was built without OpenCV's videoio; give a folder "
                  "of images");
}

VideoStream::~VideoStream() = default;

std::shared_ptr<VideoStream> VideoStream::of_file(const std::filesystem::path& path) {
  std::shared_ptr<VideoStream> stream(new VideoStream(path.string(), false));
  stream->decoder_ = std::make_unique<Decoder>(path.string(), false);
  if (!stream->decoder_->is_open())
    throw IoError(stream->name_ + ": is no video that OpenCV can read, or its end is missing; " + accepted());
  stream->count_frames();
  stream->find_rate();
  const cv::Mat first = stream->advance() ? stream->decoder_->retrieve() : cv::Mat();
  if (first.empty()) throw IoError(stream->name_ + ": has no frame that can be decoded; " + accepted());
  stream->size_px_ = first.size();
  return stream;
}

std::shared_ptr<VideoStream> VideoStream::of_camera(const std::string& address) {
  std::shared_ptr<VideoStream> stream(new VideoStream("camera:" + address, true));
  stream->decoder_ = std::make_unique<Decoder>(address, true);
  stream->size_ = kCameraFrames;
  const cv::Mat first =
      stream->decoder_->is_open() && stream->advance() ? stream->decoder_->retrieve() : cv::Mat();
  if (first.empty())
    throw IoError(stream->name_ +
                  ": no image comes from this camera: it is not there, is in use or may not be "
                  "read; give camera:N of another one");
  stream->size_px_ = first.size();
  stream->find_rate();
  return stream;
}

void VideoStream::count_frames() {
  constexpr double kEstimated = 1.02;  // a header's count that is off by this is an estimate
  const std::size_t claimed = decoder_->claimed_frames(), packets = decoder_->count_packets();
  size_ = packets > 0 ? packets : std::max<std::size_t>(1, claimed);
  if (static_cast<double>(claimed) > kEstimated * static_cast<double>(size_) + 1)
    notes_.push_back("the file says that it has " + std::to_string(claimed) + " frames, but holds " +
                     std::to_string(size_) + ": it may be truncated");
}

void VideoStream::find_rate() {
  rate_hz_ = decoder_->rate_hz();
  if (rate_hz_ >= kLeastRate_hz && rate_hz_ <= kMostRate_hz) return;
  rate_hz_ = kUsualRate_hz;
  if (!camera_) notes_.emplace_back("the video does not say its frame rate: 30 Hz are assumed");
}

std::optional<TimedImage> VideoStream::read(std::size_t i) {
  const std::lock_guard<std::mutex> lock(one_reader_);
  if (i + 1 < grabbed_) rewind();
  while (grabbed_ < i + 1)
    if (!advance()) return std::nullopt;
  TimedImage image{stamps_s_[i], decoder_->retrieve()};
  if (image.colour.empty()) throw IoError(name_ + ": frame " + std::to_string(i) + " is not an 8-bit image");
  return image;
}

void VideoStream::rewind() {
  if (camera_) throw IoError(name_ + ": a camera cannot be read again; record it with run --video first");
  decoder_->open();
  grabbed_ = 0;
}

bool VideoStream::advance() {
  if (end_ && grabbed_ >= *end_) return false;
  if (!decoder_->grab()) {
    end_ = grabbed_;
    if (!camera_ && grabbed_ < size_)
      notes_.push_back(std::to_string(size_ - grabbed_) + " of " + std::to_string(size_) +
                       " frames could not be decoded and are skipped");
    return false;
  }
  if (grabbed_ == stamps_s_.size()) stamps_s_.push_back(stamp_of(decoder_->position_s()));
  ++grabbed_;
  return true;
}

double VideoStream::stamp_of(double position_s) {
  if (stamps_s_.empty()) return std::isfinite(position_s) ? position_s : 0;
  const double last_s = stamps_s_.back();
  if (!counts_stamps_ && !(position_s > last_s)) {
    counts_stamps_ = true;
    notes_.push_back("the stamps of the video do not increase at frame " + std::to_string(stamps_s_.size()) +
                     ": from there they are counted by the frame rate");
  }
  return counts_stamps_ ? last_s + 1 / rate_hz_ : position_s;
}

double VideoStream::timestamp_s(std::size_t i) const {
  const std::lock_guard<std::mutex> lock(one_reader_);
  if (i < stamps_s_.size()) return stamps_s_[i];
  const double ahead = static_cast<double>(i + 1 - stamps_s_.size());
  return (stamps_s_.empty() ? 0 : stamps_s_.back()) + ahead / rate_hz_;
}

std::vector<std::string> VideoStream::notes() const {
  const std::lock_guard<std::mutex> lock(one_reader_);
  return notes_;
}

}  // namespace dynfilter::io
