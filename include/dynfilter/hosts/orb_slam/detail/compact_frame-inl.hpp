// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/hosts/orb_slam/compact_frame.hpp>

#include <cstring>
#include <dynfilter/core/inline.hpp>
#include <opencv2/core.hpp>

namespace dynfilter::orb_slam {

namespace detail {

DYNFILTER_INLINE void compact(cv::Mat& rows, const Keep& keep) {
  if (static_cast<std::size_t>(rows.rows) != keep.size() || rows.empty()) return;
  if (rows.u == nullptr || rows.u->refcount > 1) rows = rows.clone();
  const std::size_t bytes = static_cast<std::size_t>(rows.cols) * rows.elemSize();
  int to = 0;
  for (int from = 0; from < rows.rows; ++from) {
    std::memmove(rows.ptr(to), rows.ptr(from), bytes);
    to += keep[static_cast<std::size_t>(from)];
  }
  rows = rows.rowRange(0, to);
}

DYNFILTER_INLINE std::vector<int> new_indices(const Keep& keep) {
  std::vector<int> index(keep.size(), -1);
  int next = 0;
  for (std::size_t i = 0; i < keep.size(); ++i)
    if (keep[i] != 0) index[i] = next++;
  return index;
}

DYNFILTER_INLINE int count_first(const Keep& keep, int n) {
  int kept = 0;
  for (int i = 0; i < n && i < static_cast<int>(keep.size()); ++i) kept += keep[static_cast<std::size_t>(i)];
  return kept;
}

DYNFILTER_INLINE void renumber(std::vector<int>& partners, const std::vector<int>& index) {
  for (int& partner : partners)
    if (partner >= 0)
      partner = partner < static_cast<int>(index.size()) ? index[static_cast<std::size_t>(partner)] : -1;
}

}  // namespace detail

DYNFILTER_INLINE std::size_t compact_extracted(std::vector<cv::KeyPoint>& keypoints, cv::Mat& descriptors,
                                               const Verdict& verdict) {
  const std::size_t n = keypoints.size(), kept = verdict.kept();
  if (verdict.size() != n || kept == n) return 0;
  detail::Keep keep(n);
  for (std::size_t i = 0; i < n; ++i) keep[i] = verdict.keep(i) ? 1 : 0;
  detail::compact(keypoints, keep);
  detail::compact(descriptors, keep);
  return n - kept;
}

}  // namespace dynfilter::orb_slam
