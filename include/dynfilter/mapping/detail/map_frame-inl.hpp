// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/mapping/map_frame.hpp>

#include <algorithm>
#include <cmath>
#include <dynfilter/core/inline.hpp>
#include <opencv2/core.hpp>

namespace dynfilter::mapping {

DYNFILTER_INLINE cv::Rect pixels_of(const cv::Rect2f& box, cv::Size size) {
  if (!(box.width > 0 && box.height > 0 && std::abs(box.x) < 1e6F && std::abs(box.y) < 1e6F)) return {};
  const cv::Point from(std::max(0, cvFloor(box.x)), std::max(0, cvFloor(box.y)));
  const cv::Point to(cvCeil(std::min(box.x + box.width, static_cast<float>(size.width))),
                     cvCeil(std::min(box.y + box.height, static_cast<float>(size.height))));
  if (to.x <= from.x || to.y <= from.y) return {};
  return cv::Rect(from, to) & cv::Rect(cv::Point(), size);
}

}  // namespace dynfilter::mapping
