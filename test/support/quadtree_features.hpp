// SPDX-License-Identifier: MIT
// Features as the hosts of the ORB-SLAM family choose them: FAST corners on a pyramid, spread by a quadtree.
// cv::ORB and the odometry of the command spread differently, and a filter must not depend on how.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <opencv2/core.hpp>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>
#include <queue>
#include <tuple>
#include <vector>

namespace dynfilter_test {

/// Keeps the strongest corner of each leaf of a quadtree with about `wanted` leaves.
/// Leaves are split from large to small, so the features cover the image evenly, texture or not.
inline std::vector<cv::KeyPoint> spread_by_quadtree(std::vector<cv::KeyPoint> corners, const cv::Size2f& size,
                                                    int wanted) {
  struct Leaf {
    cv::Rect2f area;
    std::size_t first, last;
    std::size_t count() const { return last - first; }
    /// One corner needs no split; else the largest leaf comes first, then that with most corners, then the
    /// upper left.
    bool operator<(const Leaf& o) const {
      return std::make_tuple(count() > 1, area.width, count(), o.area.y, o.area.x) <
             std::make_tuple(o.count() > 1, o.area.width, o.count(), area.y, area.x);
    }
  };
  const auto begin = corners.begin();
  const auto at = [&](std::size_t i) { return begin + static_cast<std::ptrdiff_t>(i); };
  std::priority_queue<Leaf> leaves;
  const auto add = [&](const cv::Rect2f& area, std::size_t first, std::size_t last) {
    if (first < last) leaves.push({area, first, last});
  };
  const auto split = [&](std::size_t first, std::size_t last, float cv::Point2f::*axis, float value) {
    return static_cast<std::size_t>(
        std::partition(at(first), at(last), [&](const cv::KeyPoint& k) { return k.pt.*axis < value; }) -
        begin);
  };
  const int roots = std::max(1, cvRound(size.width / size.height));  // nearly square
  const float width = size.width / static_cast<float>(roots);
  std::size_t first = 0;
  for (int r = 0; r < roots; ++r) {
    const std::size_t last =
        r + 1 < roots ? split(first, corners.size(), &cv::Point2f::x, width * static_cast<float>(r + 1))
                      : corners.size();
    add({width * static_cast<float>(r), 0, width, size.height}, first, last);
    first = last;
  }
  while (!leaves.empty() && leaves.top().count() > 1 && leaves.size() < static_cast<std::size_t>(wanted)) {
    const Leaf leaf = leaves.top();
    leaves.pop();
    const float w = leaf.area.width / 2, h = leaf.area.height / 2, x = leaf.area.x + w, y = leaf.area.y + h;
    if (w < 0.5F) break;  // corners of one pixel
    const std::size_t lower = split(leaf.first, leaf.last, &cv::Point2f::y, y),
                      upper_right = split(leaf.first, lower, &cv::Point2f::x, x),
                      lower_right = split(lower, leaf.last, &cv::Point2f::x, x);
    add({leaf.area.x, leaf.area.y, w, h}, leaf.first, upper_right);
    add({x, leaf.area.y, w, h}, upper_right, lower);
    add({leaf.area.x, y, w, h}, lower, lower_right);
    add({x, y, w, h}, lower_right, leaf.last);
  }
  std::vector<cv::KeyPoint> chosen;
  for (; !leaves.empty(); leaves.pop())
    chosen.push_back(*std::max_element(
        at(leaves.top().first), at(leaves.top().last), [](const cv::KeyPoint& a, const cv::KeyPoint& b) {
          return std::tie(a.response, a.pt.y, a.pt.x) < std::tie(b.response, b.pt.y, b.pt.x);
        }));
  return chosen;
}

/// Corners of an image, and weak ones in cells without any.
inline std::vector<cv::KeyPoint> fast_corners(const cv::Mat& image) {
  constexpr int kStrong = 20, kWeak = 7, kCell_px = 30;
  std::vector<cv::KeyPoint> corners, weak;
  cv::FAST(image, corners, kStrong);
  cv::FAST(image, weak, kWeak);
  cv::Mat1b has_strong(image.rows / kCell_px + 1, image.cols / kCell_px + 1, uchar{0});
  const auto cell = [&](const cv::KeyPoint& k) -> uchar& {
    return has_strong(static_cast<int>(k.pt.y) / kCell_px, static_cast<int>(k.pt.x) / kCell_px);
  };
  for (const cv::KeyPoint& k : corners) cell(k) = 1;
  for (const cv::KeyPoint& k : weak)
    if (cell(k) == 0) corners.push_back(k);
  return corners;
}

/// About `count` features of a grey image: corners of eight pyramid levels, each spread by a quadtree.
inline std::vector<cv::KeyPoint> quadtree_features(const cv::Mat& grey, int count) {
  constexpr int kLevels = 8, kBorder = 16;
  constexpr double kStep = 1.2, kShrink = 1 / kStep;
  std::vector<cv::KeyPoint> features;
  double share = count * (1 - kShrink) / (1 - std::pow(kShrink, kLevels)), scale = 1;
  cv::Mat image = grey;
  for (int level = 0; level < kLevels; ++level, share *= kShrink, scale *= kStep) {
    if (level > 0) cv::resize(grey, image, {cvRound(grey.cols / scale), cvRound(grey.rows / scale)});
    if (std::min(image.cols, image.rows) <= 2 * kBorder) break;
    const cv::Mat inner =
        image(cv::Rect(kBorder, kBorder, image.cols - 2 * kBorder, image.rows - 2 * kBorder));
    for (cv::KeyPoint& k : spread_by_quadtree(fast_corners(inner), inner.size(), cvRound(share))) {
      k.pt = (k.pt + cv::Point2f(kBorder, kBorder)) * static_cast<float>(scale);
      k.octave = level;
      k.size = static_cast<float>(31 * scale);
      features.push_back(k);
    }
  }
  return features;
}

}  // namespace dynfilter_test
