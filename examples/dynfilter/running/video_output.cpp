// SPDX-License-Identifier: MIT
#include "video_output.hpp"

#include <algorithm>
#include <dynfilter/core/error.hpp>
#include <opencv2/core.hpp>
#include <string_view>
#include <system_error>
#include <vector>

#include "interruption.hpp"
#include "io/atomic_file.hpp"
#include "io/video_stream.hpp"

namespace dynfilter::command {
namespace {

constexpr int kRoom_px = 24;  // one more line of the legend than the first frame has

struct Container {
  std::string_view suffix;
  std::vector<std::string_view> codecs;  // the first that this OpenCV can encode
};

/// H.264 is what browsers play, MPEG-4 what every OpenCV with FFmpeg can encode.
const Container* container_of(const std::filesystem::path& file) {
  static const Container kContainers[] = {
      {".mp4", {"avc1", "mp4v"}}, {".mov", {"avc1", "mp4v"}}, {".mkv", {"avc1", "mp4v"}}, {".avi", {"MJPG"}}};
  const std::string suffix = file.extension().string();
  const auto* found = std::find_if(std::begin(kContainers), std::end(kContainers),
                                   [&](const Container& c) { return c.suffix == suffix; });
  return found == std::end(kContainers) ? nullptr : found;
}

}  // namespace

VideoOutput::VideoOutput(const std::string& file, bool force) : file_(file) {
  std::error_code error;
  const std::filesystem::path folder = file_.parent_path().empty() ? "." : file_.parent_path();
  try {
    io::media();
  } catch (const io::NoMedia& missing) {
    throw IoError("--video " + file + ": this build writes no video: " + missing.what());
  }
  if (container_of(file_) == nullptr)
    throw IoError("--video " + file + ": expected a name that ends with .mp4, .mov, .mkv or .avi");
  if (!std::filesystem::is_directory(folder, error))
    throw IoError("--video " + file + ": no such folder: " + folder.string());
  if (std::filesystem::is_directory(file_, error)) throw IoError("--video " + file + ": is a folder");
  if (!force && std::filesystem::exists(file_, error))
    throw IoError("--video " + file + ": exists: choose another name, or replace it with --force");
  partial_ = io::detail::temporary_beside(file_).string() + file_.extension().string();
  Interruption::watch();
}

VideoOutput::~VideoOutput() {
  writer_.reset();
  std::error_code error;
  std::filesystem::remove(partial_, error);
}

void VideoOutput::open(const cv::Mat& picture, double rate_hz) {
  const cv::Size size(picture.cols / 2 * 2, (picture.rows + kRoom_px) / 2 * 2);  // codecs want even sizes
  writer_ = io::media().writer();
  page_.create(size, CV_8UC3);
  for (const std::string_view codec : container_of(file_)->codecs)
    if (writer_->open(partial_, codec, rate_hz, size)) return;
  throw IoError("--video " + file_.string() +
                ": this OpenCV cannot encode it here; --video NAME.avi takes Motion "
                "JPEG, and --out writes pictures");
}

void VideoOutput::add(const cv::Mat& picture, double rate_hz) {
  if (!writer_) open(picture, rate_hz);
  const cv::Rect shared(0, 0, std::min(picture.cols, page_.cols), std::min(picture.rows, page_.rows));
  page_.setTo(picture.at<cv::Vec3b>(0, 0));
  picture(shared).copyTo(page_(shared));
  writer_->write(page_);
  ++frames_;
}

void VideoOutput::commit() {
  if (!writer_) throw IoError("--video " + file_.string() + ": there was no frame to write");
  writer_->close();
  Interruption::check();
  try {
    const auto written = io::VideoStream::of_file(partial_);
    if (written->size() < frames_) throw IoError("frames are missing");
  } catch (const IoError&) {
    throw IoError("--video " + file_.string() + ": could not be written completely: is the disk full?");
  }
  io::detail::rename_or_throw(partial_, file_);
}

}  // namespace dynfilter::command
