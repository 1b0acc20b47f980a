// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <dynfilter/config/numbers.hpp>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/error.hpp>
#include <dynfilter/pipeline/frame_observer.hpp>
#include <dynfilter/recorder/recording.hpp>
#include <filesystem>
#include <memory>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <string>
#include <system_error>
#include <utility>

#include "interruption.hpp"
#include "io/atomic_file.hpp"
#include "io/output_lock.hpp"

namespace dynfilter::command {

/// "A:B", both included.
inline std::pair<std::size_t, std::size_t> cut_range(const std::string& text) {
  const std::size_t colon = text.find(':');
  const auto number = [&](const std::string& word) {
    const std::optional<double> value = parse_number(word);
    const bool digits = !word.empty() && word.find_first_not_of("0123456789") == std::string::npos;
    if (!digits || !value || *value > 1e9)
      throw Error("--cut " + text + ": expected two frame numbers, as --cut 40:60");
    return static_cast<std::size_t>(*value);
  };
  if (colon == std::string::npos) number("");
  const std::pair<std::size_t, std::size_t> range{number(text.substr(0, colon)),
                                                  number(text.substr(colon + 1))};
  if (range.first > range.second) throw Error("--cut " + text + ": the first frame is after the last");
  return range;
}

/// A recording that appears as a whole, or not at all.
class CutFile {
 public:
  CutFile(const std::string& file, bool force)
      : path_(check(file, force)), lock_(path_), partial_(io::detail::temporary_beside(path_)) {
    Interruption::watch();
  }
  CutFile(const CutFile&) = delete;
  CutFile& operator=(const CutFile&) = delete;
  ~CutFile() {
    std::error_code ignored;
    std::filesystem::remove(partial_, ignored);
  }
  std::shared_ptr<FrameObserver> recorder() const {
    RecordingParams params;
    params.max_mb = 1'000'000;  // it is smaller than its source
    params.waits = true;
    return open_recording(partial_.string(), params);
  }
  void commit() { io::detail::rename_or_throw(partial_, path_); }

 private:
  static std::filesystem::path check(const std::string& file, bool force) {
    std::error_code error;
    if (!force && std::filesystem::exists(file, error))
      throw IoError(file + ": is there already: choose another file, or replace it with --force");
    return file;
  }
  std::filesystem::path path_;
  io::OutputLock lock_;
  std::filesystem::path partial_;
};

/// What the frame was judged on, for pictures: colours are not recorded.
inline cv::Mat recorded_picture(const recorder::RecordedFrame& frame) {
  cv::Mat colour;
  if (!frame.grey.empty() && frame.grey.type() == CV_8UC1) {
    cv::cvtColor(frame.grey, colour, cv::COLOR_GRAY2BGR);
    return colour;
  }
  constexpr int kUnknownWidth_px = 640, kUnknownHeight_px = 480, kMostSide_px = 8192;
  const Camera camera = frame.camera.value_or(Camera());
  const bool known = camera.width_px > 0 && camera.width_px <= kMostSide_px && camera.height_px > 0 &&
                     camera.height_px <= kMostSide_px;
  return {known ? camera.height_px : kUnknownHeight_px, known ? camera.width_px : kUnknownWidth_px, CV_8UC3,
          cv::Scalar::all(128)};
}

}  // namespace dynfilter::command
