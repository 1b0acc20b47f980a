// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/detection.hpp>
#include <dynfilter/core/pose.hpp>
#include <dynfilter/core/span.hpp>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace dynfilter::mapping {

/// One frame as the map takes it. Non-owning but for the images' headers; valid for one call. Only the pose,
/// the depth and the camera are required.
struct MapFrame {
  std::int64_t id = -1;  ///< unique among the keyframes of a map, >= 0
  double timestamp_s = 0;
  Pose T_world_camera;
  Camera camera;
  cv::Mat depth;            ///< CV_16UC1 or CV_32FC1; 0, NaN and infinite: none
  double depth_unit_m = 1;  ///< metres per unit of `depth`: 1 for metres, 1/5000 for TUM's uint16
  cv::Mat bgr;              ///< CV_8UC3 or CV_8UC1, of the depth's size; empty: points are grey

  cv::Mat moving_mask;                ///< CV_8UC1 of any size, non-zero: moves; empty: none
  Span<const cv::Point2f> moving_px;  ///< features that the pipeline called dynamic, distorted pixels
  Span<const cv::Point2f> still_px;   ///< features that it called static: they bound what moves; may be empty
  Span<const Detection> detections;   ///< boxes of this frame: moving things are cut out, key objects refined
  cv::Mat classes;                    ///< CV_8UC1 of the depth's size, a class per pixel, 0: none; or empty
};

/// What the map did with a frame.
struct MapReport {
  bool used = false;
  std::string note;                          ///< why it was skipped, or what was unusual
  std::size_t pixels = 0;                    ///< with a usable depth
  std::size_t cut_pixels = 0;                ///< of those: cut out as moving, with their rims
  std::size_t edge_pixels = 0;               ///< of those: left out at depth jumps
  std::size_t points = 0;                    ///< voxels of the keyframe's own cloud
  std::size_t key_points = 0;                ///< of those: of key objects, on the fine grid
  std::size_t new_voxels = 0;                ///< of the map
  std::size_t outside = 0;                   ///< points too far from the origin for the grid's keys
  bool leaf_doubled = false;                 ///< the map was full: its leaf is now twice as large
  std::vector<std::int64_t> made_permanent;  ///< keyframes that can no longer be removed or moved
  bool registered = false;                   ///< the pose was refined against the map
  Pose T_world_camera;                       ///< the pose that the cloud was fused at
  double time_ms = 0;
};

/// A cloud for files, pictures and other programs; all lists of one length (colours and classes may be
/// empty).
struct MapCloud {
  std::vector<cv::Point3f> points_m;  ///< world frame
  std::vector<cv::Vec3b> colours;     ///< blue, green, red
  /// 0: none; in key regions 1 + the place in key_classes; else the number in MapFrame::classes.
  std::vector<int> classes;

  std::size_t size() const { return points_m.size(); }
};

/// Which keyframes the points of a cloud came from: lists in the order of the cloud's points.
struct MapSources {
  std::vector<std::uint32_t> first{0};  ///< where a point's list begins; one more than points
  std::vector<std::int64_t> ids;        ///< rising in each list
  std::vector<double> timestamps_s;     ///< of these keyframes
  bool complete = true;                 ///< false: some keyframes are permanent and in no list

  std::size_t size() const { return first.size() - 1; }
  Span<const std::int64_t> ids_of(std::size_t i) const {
    return {ids.data() + first[i], first[i + 1] - first[i]};
  }
  Span<const double> stamps_s(std::size_t i) const {
    return {timestamps_s.data() + first[i], first[i + 1] - first[i]};
  }
};

/// The pixels of an image that a detection's box touches; none for a box that is no box.
inline cv::Rect pixels_of(const cv::Rect2f& box, cv::Size size) {
  if (!(box.width > 0 && box.height > 0 && std::abs(box.x) < 1e6F && std::abs(box.y) < 1e6F)) return {};
  const cv::Point from(std::max(0, cvFloor(box.x)), std::max(0, cvFloor(box.y)));
  const cv::Point to(cvCeil(std::min(box.x + box.width, static_cast<float>(size.width))),
                     cvCeil(std::min(box.y + box.height, static_cast<float>(size.height))));
  if (to.x <= from.x || to.y <= from.y) return {};
  return cv::Rect(from, to) & cv::Rect(cv::Point(), size);
}

}  // namespace dynfilter::mapping
