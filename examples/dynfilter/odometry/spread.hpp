// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

namespace dynfilter::odometry {

/// Selects strong corners with a minimum distance: suppression by square covering (Bailo et al., Pattern
/// Recognition Letters 2018).
/// Corners are visited from the strongest. Each selected one blocks a square around it.
/// The size of the square is found by bisection, so that about `wanted` corners remain.
class Spreader {
 public:
  /// The selected corners, strongest first. O(n log n + n log(image side)).
  const std::vector<cv::KeyPoint>& spread(std::vector<cv::KeyPoint>& corners, cv::Size size, int wanted) {
    std::sort(corners.begin(), corners.end(), stronger);
    if (static_cast<int>(corners.size()) <= wanted) return taken_ = corners;
    int low = 1, high = std::max(2, static_cast<int>(std::sqrt(2.0 * size.area() / std::max(1, wanted))) + 2);
    while (high - low > 1) {
      const int middle = (low + high) / 2;
      cover(corners, size, middle, wanted);
      (static_cast<int>(taken_.size()) >= wanted ? low : high) = middle;
    }
    cover(corners, size, low, wanted);
    return taken_;
  }

 private:
  static bool stronger(const cv::KeyPoint& a, const cv::KeyPoint& b) {
    if (a.response != b.response) return a.response > b.response;
    return a.pt.y != b.pt.y ? a.pt.y < b.pt.y : a.pt.x < b.pt.x;
  }

  void cover(const std::vector<cv::KeyPoint>& corners, cv::Size size, int half_side_px, int wanted) {
    const double cell_px = half_side_px / 2.0;
    const int columns = static_cast<int>(size.width / cell_px) + 1;
    const int rows = static_cast<int>(size.height / cell_px) + 1;
    blocked_.assign(static_cast<std::size_t>(columns) * rows, 0);
    taken_.clear();
    for (const cv::KeyPoint& corner : corners) {
      const int x = static_cast<int>(corner.pt.x / cell_px), y = static_cast<int>(corner.pt.y / cell_px);
      if (blocked_[static_cast<std::size_t>(y) * columns + x]) continue;
      taken_.push_back(corner);
      if (static_cast<int>(taken_.size()) >= wanted) return;
      block(x, y, columns, rows);
    }
  }

  void block(int x, int y, int columns, int rows) {
    constexpr int kReach = 2;  // in cells of half a half side
    const int left = std::max(0, x - kReach), right = std::min(columns - 1, x + kReach);
    for (int j = std::max(0, y - kReach); j <= std::min(rows - 1, y + kReach); ++j) {
      std::uint8_t* row = &blocked_[static_cast<std::size_t>(j) * columns];
      std::fill(row + left, row + right + 1, std::uint8_t{1});
    }
  }

  std::vector<std::uint8_t> blocked_;
  std::vector<cv::KeyPoint> taken_;
};

}  // namespace dynfilter::odometry
