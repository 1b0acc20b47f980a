// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <string>

#include "io/media.hpp"

namespace dynfilter::command {

/// The annotated video of `--video`. The file appears after commit(), or not at all.
class VideoOutput {
 public:
  /// Throws IoError for a name or a folder that cannot be written.
  VideoOutput(const std::string& file, bool force);
  ~VideoOutput();
  VideoOutput(const VideoOutput&) = delete;
  VideoOutput& operator=(const VideoOutput&) = delete;

  /// The first picture sets the size, with room for a second line of the legend below.
  /// Throws IoError if this OpenCV cannot encode videos.
  void add(const cv::Mat& picture, double rate_hz);

  /// Throws IoError if nothing was added, or if the file is not a complete video.
  void commit();

 private:
  void open(const cv::Mat& picture, double rate_hz);

  std::filesystem::path file_, partial_;
  std::unique_ptr<io::VideoWriter> writer_;
  cv::Mat page_;
  std::size_t frames_ = 0;
};

}  // namespace dynfilter::command
