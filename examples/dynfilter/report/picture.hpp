// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <dynfilter/core/error.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace dynfilter::command::report {

/// Bytes of all pictures of a report. In base64 they are a third more, and the page stays below 12 MB.
constexpr std::size_t kPictureBytes = 7'000'000;
/// Pictures of a report at most: more would be too small to read.
constexpr std::size_t kMostPictures = 100;
constexpr int kPictureWidth_px = 960;
/// Of a video up to this length, the report has every frame, with smaller pictures.
constexpr std::size_t kMostVideoPictures = 1000;
/// Below this size a picture is drawn and stored smaller from the start.
constexpr std::size_t kSmallPictureBytes = 25'000;
constexpr int kSmallPictureWidth_px = 480;

/// Every how many-th frame gets a picture, so that `frames` of them get at most `most`.
/// A multiple of `step`, with which the overlay pictures are drawn anyway.
inline std::size_t picture_step(std::size_t frames, std::size_t most, std::size_t step = 1) {
  const std::size_t drawn = (frames + step - 1) / step, kept = std::max<std::size_t>(1, most);
  return step * std::max<std::size_t>(1, (drawn + kept - 1) / kept);
}

/// A JPEG of at most `most_bytes`, as far as the lowest quality and the smallest size allow.
inline std::vector<std::uint8_t> encode_picture(const cv::Mat& picture, std::size_t most_bytes) {
  cv::Mat shown = picture;
  const auto narrow = [&](int width_px) {
    if (shown.cols > width_px)
      cv::resize(picture, shown, {width_px, std::max(1, picture.rows * width_px / picture.cols)}, 0, 0,
                 cv::INTER_AREA);
  };
  const bool small = most_bytes < kSmallPictureBytes;
  const std::vector<int> widths_px = small ? std::vector<int>{kSmallPictureWidth_px, 400, 320, 240, 160}
                                           : std::vector<int>{kPictureWidth_px, kPictureWidth_px * 2 / 3,
                                                              kPictureWidth_px / 3};
  std::vector<std::uint8_t> bytes;
  for (const int width_px : widths_px) {
    narrow(width_px);
    for (const int quality : {70, 55, 40}) {
      if (!cv::imencode(".jpg", shown, bytes,
                        {cv::IMWRITE_JPEG_QUALITY, quality, cv::IMWRITE_JPEG_OPTIMIZE, 1}))
        throw Error("a picture of the report cannot be encoded");
      if (bytes.size() <= most_bytes) return bytes;
    }
  }
  return bytes;
}

}  // namespace dynfilter::command::report
