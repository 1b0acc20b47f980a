// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/keyframe/frame_summary.hpp>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <dynfilter/core/inline.hpp>
#include <opencv2/core.hpp>

namespace dynfilter {

DYNFILTER_INLINE PoseDifference difference(const Pose& a, const Pose& b) {
  const Eigen::Matrix3d R = a.R().transpose() * b.R();
  const double cosine = std::min(1.0, std::max(-1.0, (R.trace() - 1) / 2));
  return {(a.t() - b.t()).norm(), std::acos(cosine) * 180 / 3.14159265358979323846};
}

DYNFILTER_INLINE std::vector<std::int64_t> sorted_points(std::vector<std::int64_t> points) {
  points.erase(std::remove_if(points.begin(), points.end(), [](std::int64_t p) { return p < 0; }),
               points.end());
  std::sort(points.begin(), points.end());
  points.erase(std::unique(points.begin(), points.end()), points.end());
  return points;
}

DYNFILTER_INLINE std::size_t shared_points(const std::vector<std::int64_t>& a,
                                           const std::vector<std::int64_t>& b) {
  std::size_t shared = 0;
  for (std::size_t i = 0, j = 0; i < a.size() && j < b.size();) {
    shared += a[i] == b[j] ? 1U : 0U;
    const bool next_a = a[i] <= b[j], next_b = b[j] <= a[i];
    i += next_a ? 1 : 0;
    j += next_b ? 1 : 0;
  }
  return shared;
}

DYNFILTER_INLINE double occupied_share(const FrameSummary& frame, int columns, int rows) {
  if (frame.image_px.width <= 0 || frame.image_px.height <= 0) return 0;
  std::vector<std::uint8_t> cells(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows), 0);
  for (const cv::Point2f& p : frame.pixels) {
    const double x = static_cast<double>(p.x) / frame.image_px.width * columns;
    const double y = static_cast<double>(p.y) / frame.image_px.height * rows;
    if (!(x >= 0 && x < columns && y >= 0 && y < rows)) continue;
    cells[static_cast<std::size_t>(y) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(x)] = 1;
  }
  return static_cast<double>(std::count(cells.begin(), cells.end(), std::uint8_t{1})) /
         static_cast<double>(cells.size());
}

}  // namespace dynfilter
