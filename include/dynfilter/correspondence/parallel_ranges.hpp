// SPDX-License-Identifier: MIT
#pragma once

#include <opencv2/core.hpp>
#include <opencv2/core/utility.hpp>

namespace dynfilter::detail {

/// Calls work(begin, end) on ranges that cover [0, count), on at most `threads` of OpenCV's threads.
template <class Work>
void in_ranges(int count, int threads, const Work& work) {
  if (threads <= 1) return work(0, count);
  cv::parallel_for_(
      {0, count}, [&](const cv::Range& range) { work(range.start, range.end); }, threads);
}

}  // namespace dynfilter::detail
