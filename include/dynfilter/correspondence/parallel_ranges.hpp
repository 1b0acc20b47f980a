// SPDX-License-Identifier: MIT
#pragma once

#include <opencv2/core.hpp>
#include <opencv2/core/utility.hpp>

namespace dynfilter::detail {

/// A loop's body for cv::parallel_for_, which copies and allocates a std::function otherwise.
/// It refers to `work`.
template <class Work>
class RangeBody : public cv::ParallelLoopBody {
 public:
  explicit RangeBody(const Work& work) : work_(work) {}
  void operator()(const cv::Range& range) const override { work_(range); }

 private:
  const Work& work_;
};

/// Calls work(begin, end) on ranges that cover [0, count), on at most `threads` of OpenCV's threads.
template <class Work>
void in_ranges(int count, int threads, const Work& work) {
  if (threads <= 1) return work(0, count);
  const auto part = [&](const cv::Range& range) { work(range.start, range.end); };
  cv::parallel_for_({0, count}, RangeBody(part), threads);
}

}  // namespace dynfilter::detail
