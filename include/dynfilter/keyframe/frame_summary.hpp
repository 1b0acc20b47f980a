// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <dynfilter/core/cells.hpp>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/keyframe/graph.hpp>
#include <opencv2/core.hpp>
#include <vector>

namespace dynfilter {

/// What a keyframe selector reads of a tracked frame. Selectors copy what they keep.
struct FrameSummary {
  std::int64_t id = -1;    ///< increases from frame to frame
  double timestamp_s = 0;  ///< increases from frame to frame
  Pose T_world_camera;     ///< translation in metres
  cv::Size image_px;       ///< empty: unknown; the spread of features then counts as 0
  /// Static map points observed by the frame, in any order; negative: no map point.
  std::vector<std::int64_t> points;
  std::vector<cv::Point2f> pixels;  ///< positions of its static features [px]
  int dynamic_features = 0;         ///< number of features rejected as moving
};

/// Reason for a keyframe.
enum class KeyframeReason {
  First,        ///< the first frame
  Gap,          ///< too many frames since the last keyframe
  FewShared,    ///< too few points of the last keyframe are still visible
  Moved,        ///< far from the last keyframe
  Cover,        ///< in the vertex cover
  Isolated,     ///< has no edge, because it shares too little with any other frame
  Bridge,       ///< connects parts
  Replacement,  ///< cleaner neighbour of a frame with too many dynamic features
};

constexpr const char* to_string(KeyframeReason reason) {
  switch (reason) {
    case KeyframeReason::First:
      return "first";
    case KeyframeReason::Gap:
      return "gap";
    case KeyframeReason::FewShared:
      return "few_shared";
    case KeyframeReason::Moved:
      return "moved";
    case KeyframeReason::Cover:
      return "cover";
    case KeyframeReason::Isolated:
      return "isolated";
    case KeyframeReason::Bridge:
      return "bridge";
    case KeyframeReason::Replacement:
      return "replacement";
  }
  return "?";
}

/// A keyframe and the reason for it.
struct SelectedFrame {
  std::int64_t id = -1;
  double timestamp_s = 0;
  KeyframeReason reason = KeyframeReason::First;
  /// More dynamic features than allowed. Map it, but remove moving objects more strictly.
  bool cut_dynamic = false;
};

/// Distance between two camera poses.
struct PoseDifference {
  double translation_m = 0, rotation_deg = 0;
};

/// Distance and angle between two camera poses in one world frame.
inline PoseDifference difference(const Pose& a, const Pose& b) {
  const Eigen::Matrix3d R = a.R().transpose() * b.R();
  const double cosine = std::min(1.0, std::max(-1.0, (R.trace() - 1) / 2));
  return {(a.t() - b.t()).norm(), std::acos(cosine) * 180 / 3.14159265358979323846};
}

/// Ascending, without duplicates and negative ids.
inline std::vector<std::int64_t> sorted_points(std::vector<std::int64_t> points) {
  points.erase(std::remove_if(points.begin(), points.end(), [](std::int64_t p) { return p < 0; }),
               points.end());
  std::sort(points.begin(), points.end());
  points.erase(std::unique(points.begin(), points.end()), points.end());
  return points;
}

/// Number of ids that two ascending lists share. Linear.
inline std::size_t shared_points(const std::vector<std::int64_t>& a, const std::vector<std::int64_t>& b) {
  std::size_t shared = 0;
  for (std::size_t i = 0, j = 0; i < a.size() && j < b.size();) {
    shared += a[i] == b[j] ? 1U : 0U;
    const bool next_a = a[i] <= b[j], next_b = b[j] <= a[i];
    i += next_a ? 1 : 0;
    j += next_b ? 1 : 0;
  }
  return shared;
}

/// Share of the cells of a `columns` x `rows` grid over the image that contain a feature. In [0, 1].
/// Ignores NaN and features outside the image. 0 without an image size.
inline double occupied_share(const FrameSummary& frame, int columns, int rows) {
  const cv::Size2f size = frame.image_px;
  if (size.width <= 0 || size.height <= 0) return 0;
  const ImageCells<double> grid{size.width, size.height, columns, rows};
  std::vector<std::uint8_t> cells(static_cast<std::size_t>(grid.count()), 0);
  for (const cv::Point2f& p : frame.pixels)
    if (p.x >= 0 && p.x < size.width && p.y >= 0 && p.y < size.height)
      cells[static_cast<std::size_t>(grid.of(p.x, p.y))] = 1;
  return static_cast<double>(std::count(cells.begin(), cells.end(), std::uint8_t{1})) /
         static_cast<double>(cells.size());
}

/// Connects two frames that share at least `min_shared` points. The lists are ascending. Cost: n^2 merges.
inline Graph covisibility_graph(const std::vector<const std::vector<std::int64_t>*>& points,
                                std::size_t min_shared) {
  Graph graph(points.size());
  for (Graph::Vertex a = 0; a < points.size(); ++a)
    for (Graph::Vertex b = a + 1; b < points.size(); ++b)
      if (shared_points(*points[a], *points[b]) >= std::max<std::size_t>(1, min_shared)) graph.connect(a, b);
  return graph;
}

}  // namespace dynfilter
