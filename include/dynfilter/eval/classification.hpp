// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>

namespace dynfilter::eval {

/// What the truth image holds per pixel (CV_8UC1).
enum class Truth : std::uint8_t { Static = 0, DontCare = 128, Dynamic = 255 };

/// The truth under a feature: at its rounded pixel of the distorted image. Outside the image (hosts have
/// keypoints at exactly x = width) nobody knows.
inline Truth truth_at(const cv::Mat& truth, const cv::Point2f& pixel) {
  const float x = std::round(pixel.x), y = std::round(pixel.y);
  if (!(x >= 0 && y >= 0 && x < static_cast<float>(truth.cols) && y < static_cast<float>(truth.rows))) {
    return Truth::DontCare;
  }
  const std::uint8_t value = truth.at<std::uint8_t>(static_cast<int>(y), static_cast<int>(x));
  return value == 0 ? Truth::Static : value == 255 ? Truth::Dynamic : Truth::DontCare;
}

/// Rejected or kept against static or dynamic, counted over features and frames. A feature whose verdict is
/// Unknown is kept. Ratios are NaN where nothing was to be divided.
struct Classification {
  std::size_t dynamic_rejected = 0, dynamic_kept = 0, static_rejected = 0, static_kept_count = 0,
              dont_care = 0;

  void add(Truth truth, bool rejected) {
    if (truth == Truth::DontCare) {
      ++dont_care;
    } else if (truth == Truth::Dynamic) {
      ++(rejected ? dynamic_rejected : dynamic_kept);
    } else {
      ++(rejected ? static_rejected : static_kept_count);
    }
  }
  void add(const Classification& other) {
    dynamic_rejected += other.dynamic_rejected;
    dynamic_kept += other.dynamic_kept;
    static_rejected += other.static_rejected;
    static_kept_count += other.static_kept_count;
    dont_care += other.dont_care;
  }

  /// Of the rejected ones, the share that is dynamic.
  double precision() const { return share(dynamic_rejected, static_rejected); }
  /// Of the dynamic ones, the share that is rejected.
  double recall() const { return share(dynamic_rejected, dynamic_kept); }
  /// Of the static ones, the share that is kept.
  double static_kept() const { return share(static_kept_count, static_rejected); }

  /// Frames before this one (counted from 0) are not pooled: a filter with a memory has none yet.
  static constexpr std::size_t kFirstFrame = 10;

 private:
  static double share(std::size_t part, std::size_t rest) {
    return part + rest == 0 ? NAN : static_cast<double>(part) / static_cast<double>(part + rest);
  }
};

}  // namespace dynfilter::eval
