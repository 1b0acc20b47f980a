// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

namespace dynfilter::odometry {

/// Finds the features in a window: cells of fixed size, features sorted by cell.
/// Undistorted features outside the image belong to the nearest cell.
class FeatureGrid {
 public:
  void build(const std::vector<cv::KeyPoint>& keypoints, cv::Size size) {
    columns_ = std::max(1, (size.width + kCell - 1) / kCell);
    rows_ = std::max(1, (size.height + kCell - 1) / kCell);
    first_.assign(static_cast<std::size_t>(columns_) * rows_ + 1, 0);
    for (const cv::KeyPoint& keypoint : keypoints) ++first_[cell(keypoint.pt) + 1];
    for (std::size_t c = 1; c < first_.size(); ++c) first_[c] += first_[c - 1];
    member_.resize(keypoints.size());
    next_ = first_;
    for (std::size_t i = 0; i < keypoints.size(); ++i)
      member_[next_[cell(keypoints[i].pt)]++] = static_cast<std::int32_t>(i);
  }

  /// Calls visit(i) for the features of all cells that touch the square window.
  template <class Visit>
  void visit(double x_px, double y_px, double radius_px, Visit&& visit) const {
    const int left = column(x_px - radius_px), right = column(x_px + radius_px);
    for (int r = row(y_px - radius_px); r <= row(y_px + radius_px); ++r) {
      const std::size_t base = static_cast<std::size_t>(r) * columns_;
      for (std::int32_t k = first_[base + left]; k < first_[base + right + 1]; ++k) visit(member_[k]);
    }
  }

 private:
  static constexpr int kCell = 20;
  int column(double x) const { return static_cast<int>(std::clamp(x / kCell, 0.0, columns_ - 1.0)); }
  int row(double y) const { return static_cast<int>(std::clamp(y / kCell, 0.0, rows_ - 1.0)); }
  std::size_t cell(cv::Point2f p) const {
    return static_cast<std::size_t>(row(p.y)) * columns_ + column(p.x);
  }

  int columns_ = 1, rows_ = 1;
  std::vector<std::int32_t> first_, next_, member_;
};

}  // namespace dynfilter::odometry
