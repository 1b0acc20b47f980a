// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <dynfilter/core/frame_view.hpp>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace dynfilter::mapping {

/// One frame for the map. Non-owning except for the image headers, and valid for one call.
/// Only the pose, the depth and the camera are required.
struct MapFrame {
  std::int64_t id = -1;  ///< unique among the keyframes of a map, >= 0
  double timestamp_s = 0;
  Pose T_world_camera;
  Camera camera;
  cv::Mat depth;  ///< CV_16UC1 or CV_32FC1; 0, NaN and infinite: no depth
  /// Metres per unit of `depth`: 1 for metres, 1/5000 for TUM's 16-bit images.
  double depth_unit_m = 1;
  /// CV_8UC3 or CV_8UC1 with the size of the depth image; empty: grey points.
  cv::Mat bgr;

  cv::Mat moving_mask;                ///< CV_8UC1 of any size, not 0: moving; empty: no mask
  Span<const cv::Point2f> moving_px;  ///< features with a dynamic verdict, distorted pixels
  /// Features with a static verdict, which bound moving objects; may be empty.
  Span<const cv::Point2f> still_px;
  /// Boxes of this frame: moving classes are removed, key objects refined.
  Span<const Detection> detections;
  /// CV_8UC1 with the size of the depth image, a class per pixel, 0: none; or empty.
  cv::Mat classes;
};

/// What the map did with a frame.
struct MapReport {
  bool used = false;
  std::string note;                          ///< reason for skipping the frame, or what was unusual
  std::size_t pixels = 0;                    ///< pixels with usable depth
  std::size_t cut_pixels = 0;                ///< of these: removed as moving, rims included
  std::size_t edge_pixels = 0;               ///< of these: removed at depth jumps
  std::size_t points = 0;                    ///< voxels of the keyframe's cloud
  std::size_t key_points = 0;                ///< of these: key objects, on the fine grid
  std::size_t new_voxels = 0;                ///< voxels new in the map
  std::size_t outside = 0;                   ///< points too far from the origin for the grid's keys
  bool leaf_doubled = false;                 ///< true if the map was full and its leaf doubled
  std::vector<std::int64_t> made_permanent;  ///< keyframes that can no longer be removed or moved
  bool registered = false;                   ///< true if the pose was refined against the map
  Pose T_world_camera;                       ///< pose at which the cloud was fused
  double time_ms = 0;
};

/// A cloud for files, pictures and other programs.
/// All lists have the same length, but colours and classes may be empty.
struct MapCloud {
  std::vector<cv::Point3f> points_m;  ///< world frame
  std::vector<cv::Vec3b> colours;     ///< blue, green, red
  /// 0: none. In key regions 1 + index in key_classes, else the number in MapFrame::classes.
  std::vector<int> classes;

  std::size_t size() const { return points_m.size(); }
};

/// The keyframes that contribute to each point of a cloud, as lists in the order of the points.
struct MapSources {
  std::vector<std::uint32_t> first{0};  ///< start of each point's list; one more entry than points
  std::vector<std::int64_t> ids;        ///< increasing in each list
  std::vector<double> timestamps_s;     ///< of these keyframes
  /// False: some contributing keyframes are permanent and not listed.
  bool complete = true;

  std::size_t size() const { return first.size() - 1; }
  /// The times of these keyframes.
  Span<const double> stamps_s(std::size_t i) const {
    return {timestamps_s.data() + first[i], first[i + 1] - first[i]};
  }
};

/// The pixels of an image that a box touches. Empty for an invalid box.
inline cv::Rect pixels_of(const cv::Rect2f& box, cv::Size size) {
  if (!(box.width > 0 && box.height > 0 && std::abs(box.x) < 1e6F && std::abs(box.y) < 1e6F)) return {};
  const cv::Point from(std::max(0, cvFloor(box.x)), std::max(0, cvFloor(box.y)));
  const cv::Point to(cvCeil(std::min(box.x + box.width, static_cast<float>(size.width))),
                     cvCeil(std::min(box.y + box.height, static_cast<float>(size.height))));
  if (to.x <= from.x || to.y <= from.y) return {};
  return cv::Rect(from, to) & cv::Rect(cv::Point(), size);
}

}  // namespace dynfilter::mapping
