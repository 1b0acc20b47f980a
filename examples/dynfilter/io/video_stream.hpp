// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <mutex>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <vector>

#include "io/media.hpp"

namespace dynfilter::io {

struct TimedImage {
  double timestamp_s = 0;
  cv::Mat colour;  ///< CV_8UC3, upright: the container's rotation is applied
};

/// Images of a video file or a camera, decoded one after another and never sought.
/// One image is in memory at a time, and eight bytes for the stamp of each.
class VideoStream {
 public:
  /// What is accepted, for errors.
  static std::string accepted();

  /// Throws IoError if no image of the file can be decoded, and without OpenCV's videoio.
  static std::shared_ptr<VideoStream> of_file(const std::filesystem::path& path);

  /// `address`: the number of a camera, its device file, or a stream's address.
  /// Throws IoError if no image comes from there.
  static std::shared_ptr<VideoStream> of_camera(const std::string& address);

  VideoStream(const VideoStream&) = delete;
  VideoStream& operator=(const VideoStream&) = delete;

  /// Image i, or nullopt if the stream ended before. An image before the last one that was read decodes the
  /// file again from its start. Throws IoError for one of a camera.
  std::optional<TimedImage> read(std::size_t i);

  /// Frames that the container counts, without decoding them. A damaged file has fewer.
  /// Of a camera a number that is never reached.
  std::size_t size() const { return size_; }
  bool is_camera() const { return camera_; }
  cv::Size size_px() const { return size_px_; }
  double rate_hz() const { return rate_hz_; }

  /// Of an image that was read. Of any other one what the rate lets expect.
  double timestamp_s(std::size_t i) const;

  /// What was odd so far, one line each.
  std::vector<std::string> notes() const;

 private:
  VideoStream(std::string name, bool camera, const std::string& address);

  void count_frames();
  void find_rate();
  bool advance();
  double stamp_of(double position_s);
  void rewind();

  std::string name_;
  bool camera_;
  std::unique_ptr<VideoReader> decoder_;
  mutable std::mutex one_reader_;
  std::size_t size_ = 0;
  cv::Size size_px_;
  double rate_hz_ = 0;
  std::size_t grabbed_ = 0;       ///< images so far; the last one may not be converted yet
  std::vector<double> stamps_s_;  ///< of the images so far, also after rewind()
  bool counts_stamps_ = false;    ///< the container's stamps cannot be used any more
  std::vector<std::string> notes_;
  std::optional<std::size_t> end_;  ///< number of images, once known
};

}  // namespace dynfilter::io
