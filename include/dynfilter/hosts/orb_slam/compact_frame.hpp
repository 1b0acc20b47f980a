// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/verdict.hpp>
#include <dynfilter/hosts/orb_slam/traits.hpp>
#include <opencv2/core/mat.hpp>

namespace dynfilter::orb_slam {

namespace detail {

using Keep = std::vector<std::uint8_t>;

/// Drops the entries whose `keep` is 0. An array of another length is not parallel to it and stays. Without
/// branches, which would be mispredicted.
template <class T>
void compact(std::vector<T>& values, const Keep& keep) {
  if (values.size() != keep.size()) return;
  std::size_t to = 0;
  for (std::size_t from = 0; from < keep.size(); ++from) {
    values[to] = static_cast<T>(values[from]);
    to += keep[from];
  }
  values.erase(values.begin() + static_cast<std::ptrdiff_t>(to), values.end());
}
/// Rows of a matrix. Other matrices that share these rows are unchanged.
void compact(cv::Mat& rows, const Keep& keep);

/// The new index of each old one, -1 for those that were dropped.
std::vector<int> new_indices(const Keep& keep);

int count_first(const Keep& keep, int n);

template <class Grid>
void clear_grid(Grid& grid) {
  for (auto& column : grid)
    for (auto& cell : column) cell.clear();
}

template <class Frame, class Grid>
void fill_grid(Frame& frame, const std::vector<cv::KeyPoint>& keypoints, Grid& grid) {
  clear_grid(grid);
  for (std::size_t i = 0; i < keypoints.size(); ++i) {
    int column = 0, row = 0;
    if (frame.PosInGrid(keypoints[i], column, row)) grid[column][row].push_back(i);
  }
}

template <class Frame>
void forget_words(Frame& frame) {
  frame.mBowVec.clear();
  frame.mFeatVec.clear();
}

template <class Frame>
void compact_single(Frame& frame, const Keep& keep) {
  compact(frame.mvKeys, keep);
  compact(frame.mvKeysUn, keep);
  compact(frame.mDescriptors, keep);
  compact(frame.mvDepth, keep);
  compact(frame.mvuRight, keep);
  compact(frame.mvpMapPoints, keep);
  compact(frame.mvbOutlier, keep);
  frame.N = static_cast<int>(frame.mvKeys.size());
  fill_grid(frame, frame.mvKeysUn, frame.mGrid);
}

/// Right features that are matched to a rejected left one are dropped.
template <class Frame>
Keep keep_of_right(const Frame& frame, const Keep& left) {
  Keep right(frame.mvKeysRight.size(), 1);
  for (std::size_t i = 0; i < left.size() && i < frame.mvLeftToRightMatch.size(); ++i) {
    const int partner = frame.mvLeftToRightMatch[i];
    if (left[i] == 0 && partner >= 0 && partner < static_cast<int>(right.size()))
      right[static_cast<std::size_t>(partner)] = 0;
  }
  return right;
}

void renumber(std::vector<int>& partners, const std::vector<int>& index);

/// Arrays are as long as the left camera's features, the right one's, or both, left first.
template <class Frame>
void compact_pair(Frame& frame, const Keep& left) {
  const Keep right = keep_of_right(frame, left);
  Keep both = left;
  both.insert(both.end(), right.begin(), right.end());
  frame.monoLeft = count_first(left, frame.monoLeft);
  frame.monoRight = count_first(right, frame.monoRight);
  compact(frame.mvKeys, left);
  compact(frame.mvKeysUn, frame.mvKeysUn.size() == left.size() ? left : both);
  compact(frame.mvKeysRight, right);
  compact(frame.mDescriptors, both);
  compact(frame.mDescriptorsRight, right);
  compact(frame.mvDepth, left);
  compact(frame.mvuRight, left);
  compact(frame.mvStereo3Dpoints, left);
  compact(frame.mvLeftToRightMatch, left);
  compact(frame.mvRightToLeftMatch, right);
  renumber(frame.mvLeftToRightMatch, new_indices(right));
  renumber(frame.mvRightToLeftMatch, new_indices(left));
  compact(frame.mvpMapPoints, both);
  compact(frame.mvbOutlier, both);
  frame.Nleft = static_cast<int>(frame.mvKeys.size());
  frame.Nright = static_cast<int>(frame.mvKeysRight.size());
  frame.N = frame.Nleft + frame.Nright;
  fill_grid(frame, frame.mvKeys, frame.mGrid);
  fill_grid(frame, frame.mvKeysRight, frame.mGridRight);
}

}  // namespace detail

/// Call points B and C. Removes the rejected features from every parallel array of the frame and sets N.
/// Refills the grid by the host's PosInGrid, and clears the bag of words, which the host computes when it
/// needs it. The order of the others stays. `verdict` is about mvKeys. With another size, nothing is done.
/// Returns the number of removed features.
template <class Frame>
std::size_t compact_frame(Frame& frame, const Verdict& verdict) {
  require_frame<Frame>();
  const std::size_t n = frame.mvKeys.size(), kept = verdict.kept();
  if (verdict.size() != n || kept == n) return 0;
  detail::Keep keep(n);
  for (std::size_t i = 0; i < n; ++i) keep[i] = verdict.keep(i) ? 1 : 0;
  detail::forget_words(frame);
  if constexpr (traits::HasTwoCameras<Frame>::value) {
    if (is_pair(frame)) {
      detail::compact_pair(frame, keep);
      return n - kept;
    }
  }
  detail::compact_single(frame, keep);
  return n - kept;
}

/// Call point A, inside the host's constructor: only keypoints and descriptors exist.
std::size_t compact_extracted(std::vector<cv::KeyPoint>& keypoints, cv::Mat& descriptors,
                              const Verdict& verdict);

}  // namespace dynfilter::orb_slam

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/hosts/orb_slam/detail/compact_frame-inl.hpp>
#endif
