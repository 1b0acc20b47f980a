// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <dynfilter/core/pose.hpp>
#include <opencv2/core/types.hpp>
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
PoseDifference difference(const Pose& a, const Pose& b);

/// Ascending, without duplicates and negative ids.
std::vector<std::int64_t> sorted_points(std::vector<std::int64_t> points);

/// Number of ids that two ascending lists share. Linear.
std::size_t shared_points(const std::vector<std::int64_t>& a, const std::vector<std::int64_t>& b);

/// Share of the cells of a `columns` x `rows` grid over the image that contain a feature.
/// In [0, 1].
/// Ignores NaN and features outside the image. 0 without an image size.
double occupied_share(const FrameSummary& frame, int columns, int rows);

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/keyframe/detail/frame_summary-inl.hpp>
#endif
