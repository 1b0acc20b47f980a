// SPDX-License-Identifier: MIT
#include "eval/classification.hpp"

#include <opencv2/core.hpp>

namespace dynfilter::eval {

TruthPixel truth_at(const cv::Mat& truth, const cv::Point2f& pixel) {
  const float x = std::round(pixel.x), y = std::round(pixel.y);
  if (!(x >= 0 && y >= 0 && x < static_cast<float>(truth.cols) && y < static_cast<float>(truth.rows))) {
    return TruthPixel::DontCare;
  }
  const std::uint8_t value = truth.at<std::uint8_t>(static_cast<int>(y), static_cast<int>(x));
  return value == 0 ? TruthPixel::Static : value == 255 ? TruthPixel::Dynamic : TruthPixel::DontCare;
}

void Classification::add(TruthPixel truth, bool rejected) {
  if (truth == TruthPixel::DontCare) {
    ++dont_care;
  } else if (truth == TruthPixel::Dynamic) {
    ++(rejected ? dynamic_rejected : dynamic_kept);
  } else {
    ++(rejected ? static_rejected : static_kept_count);
  }
}

void Classification::add(const Classification& other) {
  dynamic_rejected += other.dynamic_rejected;
  dynamic_kept += other.dynamic_kept;
  static_rejected += other.static_rejected;
  static_kept_count += other.static_kept_count;
  dont_care += other.dont_care;
}

}  // namespace dynfilter::eval
