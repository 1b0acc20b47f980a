// SPDX-License-Identifier: MIT
#include <dynfilter/filters/detail/grid_motion_statistics.hpp>

std::size_t matches_of(const std::vector<cv::Point2f>& points) {
  dynfilter::GridMotionStatistics statistics;
  std::vector<std::uint8_t> kept;
  const cv::Size size(640, 480);
  return statistics.run(points, size, points, size, {}, kept);
}
