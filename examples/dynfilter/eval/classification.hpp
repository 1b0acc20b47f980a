// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>

namespace dynfilter::eval {

/// Pixel values of the truth image (CV_8UC1).
enum class TruthPixel : std::uint8_t { Static = 0, DontCare = 128, Dynamic = 255 };

/// The truth at the rounded pixel of a feature in the distorted image.
/// DontCare outside the image; some hosts have keypoints at x = width.
TruthPixel truth_at(const cv::Mat& truth, const cv::Point2f& pixel);

/// Counts of rejected and kept features, static and dynamic, over all frames.
/// A feature with verdict Unknown counts as kept. A ratio without features is NaN.
struct Classification {
  std::size_t dynamic_rejected = 0, dynamic_kept = 0, static_rejected = 0, static_kept_count = 0,
              dont_care = 0;

  void add(TruthPixel truth, bool rejected);
  void add(const Classification& other);

  /// Share of the rejected features that are dynamic.
  double precision() const { return share(dynamic_rejected, static_rejected); }
  /// Share of the dynamic features that are rejected.
  double recall() const { return share(dynamic_rejected, dynamic_kept); }
  /// Share of the static features that are kept.
  double static_kept() const { return share(static_kept_count, static_rejected); }

  /// Frames before this one, counted from 0, are excluded:
  /// filters need time to fill their state.
  static constexpr std::size_t kFirstFrame = 10;

 private:
  static double share(std::size_t part, std::size_t rest) {
    return part + rest == 0 ? NAN : static_cast<double>(part) / static_cast<double>(part + rest);
  }
};

}  // namespace dynfilter::eval
