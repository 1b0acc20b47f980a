// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <dynfilter/core/error.hpp>
#include <dynfilter/detectors/image_encoder.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace dynfilter::command::report {

/// Bytes of all pictures of a report. In base64 they are a third more. With maps and rows the page stays
/// below 10 MB.
constexpr std::size_t kPictureBytes = 4'500'000;
/// Frames with figures of all runs of a report, about 300 bytes each. A longer run is thinned.
constexpr std::size_t kMostRows = 7500, kLeastRows = 200;
/// Pictures of a report at most: more would be too small to read.
constexpr std::size_t kMostPictures = 100;
/// Of each run in a report of many, which then has smaller ones.
constexpr std::size_t kLeastPictures = 8;
constexpr int kPictureWidth_px = 960;
/// Of a video up to this length, the report has every frame, with smaller pictures.
constexpr std::size_t kMostVideoPictures = 1000;
/// Below this size a picture is drawn and stored smaller from the start.
constexpr std::size_t kSmallPictureBytes = 25'000;
constexpr int kSmallPictureWidth_px = 480;

/// What one of several runs may take of a report.
struct RunShare {
  explicit RunShare(std::size_t runs)
      : pictures(std::max(kLeastPictures, kMostPictures / std::max<std::size_t>(1, runs))),
        picture_bytes(kPictureBytes / std::max<std::size_t>(1, runs)),
        rows(std::max(kLeastRows, kMostRows / std::max<std::size_t>(1, runs))) {}

  std::size_t pictures, picture_bytes, rows;
};

/// Every how many-th frame gets a picture, so that `frames` of them get at most `most`.
/// A multiple of `step`, with which the overlay pictures are drawn anyway.
inline std::size_t picture_step(std::size_t frames, std::size_t most, std::size_t step = 1) {
  const std::size_t drawn = (frames + step - 1) / step, kept = std::max<std::size_t>(1, most);
  return step * std::max<std::size_t>(1, (drawn + kept - 1) / kept);
}

/// Encodes pictures of one size in bytes each, as far as the lowest quality and the smallest width allow.
/// It begins with what fitted the last picture, because those of a recording are alike.
class PictureEncoder {
 public:
  explicit PictureEncoder(std::size_t most_bytes) : most_bytes_(most_bytes) {
    const bool small = most_bytes < kSmallPictureBytes;
    const std::vector<int> widths_px =
        small ? std::vector<int>{kSmallPictureWidth_px, 400, 320, 240, 160}
              : std::vector<int>{kPictureWidth_px, kPictureWidth_px * 2 / 3, kPictureWidth_px / 3};
    const std::vector<int> qualities = small ? std::vector<int>{60, 40, 25} : std::vector<int>{70, 55, 40};
    for (const int width_px : widths_px)
      for (const int quality : qualities) forms_.push_back({width_px, quality});
  }

  std::vector<std::uint8_t> encode(const cv::Mat& picture) {
    std::vector<std::uint8_t> bytes;
    if (form_ > 0) --form_;  // this one may be simpler
    for (;; ++form_) {
      bytes = jpeg(picture, forms_[form_]);
      if (bytes.size() <= most_bytes_ || form_ + 1 == forms_.size()) return bytes;
    }
  }

 private:
  struct Form {
    int width_px, quality;
  };

  static std::vector<std::uint8_t> jpeg(const cv::Mat& picture, const Form& form) {
    cv::Mat shown = picture;
    if (picture.cols > form.width_px)
      cv::resize(picture, shown, {form.width_px, std::max(1, picture.rows * form.width_px / picture.cols)}, 0,
                 0, cv::INTER_AREA);
    return io::encode_jpeg(shown, form.quality);
  }

  std::size_t most_bytes_;
  std::vector<Form> forms_;
  std::size_t form_ = 0;
};

}  // namespace dynfilter::command::report
