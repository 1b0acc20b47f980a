// SPDX-License-Identifier: MIT
#include "io/video_stream.hpp"

#include <algorithm>
#include <cmath>
#include <dynfilter/core/error.hpp>
#include <utility>

namespace dynfilter::io {
namespace {

constexpr double kUsualRate_hz = 30;
constexpr double kLeastRate_hz = 0.1, kMostRate_hz = 1000;  // others are a container's nonsense
constexpr std::size_t kCameraFrames = 1'000'000;            // nine hours at 30 Hz

}  // namespace

std::string VideoStream::accepted() {
  return "accepted are a folder, a video file (mp4, mov, mkv, webm, avi, ...), camera:0 and 'frames/*.png'";
}

VideoStream::VideoStream(std::string name, bool camera, const std::string& address)
    : name_(std::move(name)), camera_(camera) {
  try {
    decoder_ = media().reader(address, camera);
  } catch (const NoMedia& missing) {
    throw IoError(name_ + ": this build reads no video: " + missing.what() + "; give a folder of images");
  }
}

std::shared_ptr<VideoStream> VideoStream::of_file(const std::filesystem::path& path) {
  std::shared_ptr<VideoStream> stream(new VideoStream(path.string(), false, path.string()));
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
  std::shared_ptr<VideoStream> stream(new VideoStream("camera:" + address, true, address));
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
