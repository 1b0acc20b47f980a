// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <dynfilter/correspondence/image_pyramid.hpp>
#include <dynfilter/correspondence/small_window.hpp>
#include <limits>
#include <opencv2/core.hpp>
#include <vector>

namespace dynfilter::detail {

/// Flow of a grid of patches, from the top level of two pyramids down to level 1.
/// It depends on the images alone, so the result of a point does not depend on other points.
class CoarseFlow {
 public:
  using Around = std::array<cv::Point2f, 4>;

  /// Each node starts from the node of the level above that makes the patches most alike.
  /// A node without texture keeps that start.
  template <class Kernels>
  void compute(const std::vector<cv::Mat>& from, const std::vector<cv::Mat>& to, int window_px,
               double min_eigenvalue, int threads);

  /// Flow of the four nodes around a pixel of level 0, in pixels of level 0. Zero without compute().
  Around around(const cv::Point2f& px) const { return around(px, kBottom); }

 private:
  static constexpr int kBottom = 1;
  static constexpr int kSpacingPx = 12;  ///< between nodes, in pixels of their level
  static constexpr int kMaxIterations = 5;
  static constexpr float kEpsilonPx = 0.1F;  ///< the level below refines it

  struct Grid {
    int columns = 0, rows = 0;
    std::vector<cv::Point2f> flow;  ///< in pixels of level 0, row by row
    const cv::Point2f& at(int x, int y) const { return flow[index(x, y)]; }
    cv::Point2f& at(int x, int y) { return flow[index(x, y)]; }
    std::size_t index(int x, int y) const {
      return static_cast<std::size_t>(y) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(x);
    }
  };
  static int nodes(int length_px) { return std::max(1, length_px / kSpacingPx); }
  static float node_px(int k) { return (static_cast<float>(k) + 0.5F) * kSpacingPx; }

  Around around(const cv::Point2f& px, int level) const;

  template <class Kernels>
  cv::Point2f node_flow(const cv::Mat& from, const cv::Mat& to, const cv::Point2f& node, int level,
                        double min_eigenvalue, SmallWindow<Kernels>& window) const;

  std::vector<Grid> grids_;  ///< by level
};

/// The flow with which the image looks most like the window's patch. Of equal ones the first.
template <class Kernels, std::size_t N>
cv::Point2f most_alike(const SmallWindow<Kernels>& window, const cv::Mat& image, const cv::Point2f& px,
                       const std::array<cv::Point2f, N>& flows, float scale) {
  constexpr float kSamePx = 0.5F;  // nearer ones converge to the same place
  cv::Point2f best = flows[0];
  float least = std::numeric_limits<float>::infinity();
  for (std::size_t k = 0; k < N; ++k) {
    const auto is_same = [&](const cv::Point2f& other) {
      const cv::Point2f apart = (flows[k] - other) * scale;
      return apart.dot(apart) < kSamePx * kSamePx;
    };
    const auto end = flows.begin() + static_cast<std::ptrdiff_t>(k);
    if (std::any_of(flows.begin(), end, is_same)) continue;
    const float difference = window.difference(image, (px + flows[k]) * scale);
    if (difference < least) least = difference, best = flows[k];
  }
  return best;
}

template <class Kernels>
void CoarseFlow::compute(const std::vector<cv::Mat>& from, const std::vector<cv::Mat>& to, int window_px,
                         double min_eigenvalue, int threads) {
  grids_.resize(std::min(from.size(), to.size()));
  for (int level = static_cast<int>(grids_.size()) - 1; level >= kBottom; --level) {
    const auto l = static_cast<std::size_t>(level);
    Grid& grid = grids_[l];
    grid.columns = nodes(from[l].cols), grid.rows = nodes(from[l].rows);
    grid.flow.assign(grid.index(0, grid.rows), cv::Point2f());
    in_ranges(grid.rows, threads, [&](int begin, int end) {
      SmallWindow<Kernels> window(window_px);
      for (int y = begin; y < end; ++y)
        for (int x = 0; x < grid.columns; ++x)
          grid.at(x, y) = node_flow(from[l], to[l], {node_px(x), node_px(y)}, level, min_eigenvalue, window);
    });
  }
}

template <class Kernels>
cv::Point2f CoarseFlow::node_flow(const cv::Mat& from, const cv::Mat& to, const cv::Point2f& node, int level,
                                  double min_eigenvalue, SmallWindow<Kernels>& window) const {
  const auto level_0 = static_cast<float>(1 << level);
  const float scale = 1 / level_0;
  const cv::Point2f px = node * level_0;
  const Around above = around(px, level + 1);
  if (!window.cut(from, node)) return above[0];
  const cv::Point2f start = most_alike(window, to, px, above, scale);
  cv::Point2f at = node + start * scale;
  if (!window.textured(min_eigenvalue) || !window.refine(to, kMaxIterations, kEpsilonPx, at)) return start;
  return (at - node) * level_0;
}

inline CoarseFlow::Around CoarseFlow::around(const cv::Point2f& px, int level) const {
  const auto l = static_cast<std::size_t>(level);
  if (l >= grids_.size()) return {};
  const Grid& grid = grids_[l];
  const float spacing_px = static_cast<float>(kSpacingPx << level);
  const auto before = [&](float at_px, int count) {
    return std::clamp(cvFloor(at_px / spacing_px - 0.5F), 0, std::max(0, count - 2));
  };
  const int x = before(px.x, grid.columns), y = before(px.y, grid.rows);
  const int next_x = std::min(x + 1, grid.columns - 1), next_y = std::min(y + 1, grid.rows - 1);
  return {grid.at(x, y), grid.at(next_x, y), grid.at(x, next_y), grid.at(next_x, next_y)};
}

}  // namespace dynfilter::detail
