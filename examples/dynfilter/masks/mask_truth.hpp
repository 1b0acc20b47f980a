// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstdint>
#include <opencv2/core/mat.hpp>

namespace dynfilter::masks {

/// Pixels of masks against labels, over all frames of a sequence.
struct MaskCounts {
  std::int64_t mover_masked = 0, mover_free = 0, static_masked = 0, static_free = 0;

  /// `moving`: nonzero on what is masked. `labels`: 0 static, else a mover. Both CV_8UC1, of one size.
  void add(const cv::Mat& moving, const cv::Mat& labels);

  /// Pixels that are masked and on a mover, by those that are either. NaN if there are none.
  double intersection_over_union() const { return share(mover_masked, mover_free + static_masked); }
  /// Share of the movers' pixels that is masked.
  double movers_masked() const { return share(mover_masked, mover_free); }
  /// Share of the static pixels that is masked, and so lost.
  double static_lost() const { return share(static_masked, static_free); }

 private:
  static double share(std::int64_t part, std::int64_t rest) {
    return part + rest == 0 ? NAN : static_cast<double>(part) / static_cast<double>(part + rest);
  }
};

inline void MaskCounts::add(const cv::Mat& moving, const cv::Mat& labels) {
  for (int y = 0; y < moving.rows; ++y) {
    const auto *m = moving.ptr<std::uint8_t>(y), *l = labels.ptr<std::uint8_t>(y);
    for (int x = 0; x < moving.cols; ++x) {
      if (l[x] != 0)
        ++(m[x] != 0 ? mover_masked : mover_free);
      else
        ++(m[x] != 0 ? static_masked : static_free);
    }
  }
}

}  // namespace dynfilter::masks
