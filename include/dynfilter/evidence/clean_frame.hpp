// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <dynfilter/core/frame_inputs.hpp>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/limits.hpp>
#include <dynfilter/core/point_grid.hpp>
#include <dynfilter/evidence/crowded_places.hpp>
#include <iterator>
#include <limits>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

namespace dynfilter {

/// Cleans a host's frame once, so that filters need no checks of their own. Afterwards these hold:
///  - arrays are empty or as long as the keypoints;
///  - an input that is there has a usable value (hosts fill what they lack: ORB-SLAM has N times -1);
///  - images have a supported type;
///  - a camera has a focal length, or only an image size (focal lengths 0, no distortion);
///  - a pose is rigid;
///  - boxes have an area and a score in [0, 1], and there are at most limits::kMaxBoxes, or fewer with many
///    features (limits::kMaxBoxFeaturePairs);
///  - pixel positions are NaN or within 1e6 pixels, and at most limits::kMaxCrowd are in a square of
///    limits::kCrowd_px.
/// Of more boxes those with the highest scores are kept. Of more than limits::kMaxFeatures features none is
/// judged, and none of those in a more crowded square. Unusable input is removed, with a note. So is an input
/// without a usable value, as if it had not been given. Where hosts fill arrays with "none" (depths, right
/// columns, map points, matches), there is no note. An unusual array is replaced by a copy in this object,
/// valid until the next call.
class FrameCleaner {
 public:
  void clean(FrameView& frame);  ///< removes from `frame` what cannot be used, with a note for each
  /// Releases the host's masks.
  void end() { detections_.clear(); }
  /// What was removed from the last frame, e.g. "depth_m cannot be used: wrong size or type".
  const std::vector<std::string>& notes() const { return notes_; }

 private:
  static constexpr float kMaxPixel = PointGrid::kMaxPixel;
  static constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

  template <class Member>
  void drop(bool unusable, const char* note, Member& member);
  template <class Member>
  void drop_input(bool unusable, const char* what, Member& member);
  void note_wrong(const char* what) {
    notes_.push_back(std::string(what) + " cannot be used: wrong size or type");
  }
  void drop_odd_arrays(FrameView& frame);
  void drop_odd_images(FrameView& frame);

  /// What is there but has no usable value. The only place that decides this.
  void drop_empty(FrameView& frame);
  void drop_empty_keyframes(FrameView& frame);
  static bool has_depth(const cv::Mat& image);

  /// Returns false if there are too many features; then no feature has a position.
  bool clean_count(FrameView& frame);
  void clean_places(FrameView& frame);
  /// How many positions were set to NaN, and why.
  struct Dropped {
    std::size_t nowhere = 0, crowded = 0;
  };
  Dropped clean_places(Span<const cv::KeyPoint>& given, std::vector<cv::KeyPoint>& own);
  void clean_boxes(FrameView& frame);
  static bool is_usable(const Detection& detection);
  static bool is_usable_box(const cv::Rect2f& box);
  /// Clips a box that reaches far beyond the image, so that its part in the image remains.
  static cv::Rect2f clipped(const cv::Rect2f& box);
  /// The box as filters may use it, or nullopt.
  static std::optional<cv::Rect2f> usable_box(const Detection& detection);
  /// Keeps `most` boxes with the highest scores in kept_, in the order given.
  void keep_best(Span<const Detection> given, std::size_t most);

  static bool is_usable(const Camera& camera);

  std::vector<std::string> notes_;
  CrowdedPlaces crowds_;
  std::vector<cv::KeyPoint> keypoints_, undistorted_;
  std::vector<Detection> detections_;
  std::vector<KeyframeView> keyframes_;
  std::vector<std::size_t> kept_;
};

inline void FrameCleaner::clean(FrameView& frame) {
  notes_.clear();
  drop_odd_arrays(frame);
  drop_odd_images(frame);
  if (clean_count(frame)) clean_places(frame);
  clean_boxes(frame);
  drop(frame.camera && !is_usable(*frame.camera), "camera cannot be used: not finite or out of range",
       frame.camera);
  drop_empty(frame);
  if (frame.pose_provenance != PoseProvenance::None && !is_rigid(frame.T_world_camera)) {
    notes_.emplace_back("pose cannot be used: not rigid");
    frame.pose_provenance = PoseProvenance::None;
  }
  drop(frame.motion_prior && !frame.motion_prior->valid(),
       "motion prior cannot be used: not rigid, or its covariance is none", frame.motion_prior);
}

template <class Member>
void FrameCleaner::drop(bool unusable, const char* note, Member& member) {
  if (!unusable) return;
  notes_.emplace_back(note);
  member = Member();
}

template <class Member>
void FrameCleaner::drop_input(bool unusable, const char* what, Member& member) {
  if (!unusable) return;
  note_wrong(what);
  member = Member();
}

inline void FrameCleaner::drop_odd_arrays(FrameView& frame) {
  const std::size_t n = frame.size();
  const auto odd = [n](const auto& span) { return !span.empty() && span.size() != n; };
  drop_input(odd(frame.depth_m), "depth_m", frame.depth_m);
  drop_input(odd(frame.right_u_px), "right_u_px", frame.right_u_px);
  drop_input(odd(frame.keypoints_undistorted), "keypoints_undistorted", frame.keypoints_undistorted);
  drop_input(odd(frame.map_point_ids), "map_point_ids", frame.map_point_ids);
  drop_input(odd(frame.map_points_world_m), "map_points_world_m", frame.map_points_world_m);
  drop_input(!frame.descriptors.empty() && (static_cast<std::size_t>(frame.descriptors.rows) != n ||
                                            frame.descriptors.type() != CV_8UC1),
             "descriptors", frame.descriptors);
  drop_input(frame.matches && frame.matches->reference_index.size() != n, "matches", frame.matches);
}

inline void FrameCleaner::drop_odd_images(FrameView& frame) {
  cv::Mat &grey = frame.grey, &depth = frame.depth, &right = frame.right_grey;
  drop_input(!grey.empty() && grey.type() != CV_8UC1, "grey", grey);
  drop_input(!right.empty() && (right.type() != CV_8UC1 || right.size() != grey.size()), "right_grey", right);
  drop(!right.empty() && frame.camera && frame.camera->distorted(),
       "right_grey cannot be used: the camera says that images are not rectified", right);
  drop_input(!depth.empty() && depth.type() != CV_16UC1 && depth.type() != CV_32FC1, "depth", depth);
  drop_input(!depth.empty() && !grey.empty() && depth.size() != grey.size(), "depth", depth);
  drop(!depth.empty() && !(frame.depth_unit_m > 0 && std::isfinite(frame.depth_unit_m)),
       "depth cannot be used: its unit is not a positive length", depth);
  drop_input(frame.mask && (frame.mask->labels.empty() || frame.mask->labels.type() != CV_8UC1), "mask",
             frame.mask);
}

inline void FrameCleaner::drop_empty(FrameView& frame) {
  const auto none = [](const auto& span, const auto& usable) {
    return !span.empty() && std::none_of(span.begin(), span.end(), usable);
  };
  const auto is_place = [](const cv::KeyPoint& keypoint) { return !std::isnan(keypoint.pt.x); };
  const auto is_point = [](const cv::Point3f& p) {
    return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
  };
  const auto is_index = [](std::int64_t index) { return index >= 0; };
  if (none(frame.depth_m, valid_depth)) frame.depth_m = {};
  if (none(frame.right_u_px, valid_right)) frame.right_u_px = {};
  if (none(frame.map_point_ids, is_index)) frame.map_point_ids = {};
  if (none(frame.map_points_world_m, is_point)) frame.map_points_world_m = {};
  if (frame.matches && none(frame.matches->reference_index, is_index)) frame.matches.reset();
  // No host fills these with "none".
  const bool any_place = std::any_of(frame.keypoints.begin(), frame.keypoints.end(), is_place);
  drop(any_place && none(frame.keypoints_undistorted, is_place), "keypoints_undistorted: none is in an image",
       frame.keypoints_undistorted);
  drop(!frame.depth.empty() && !has_depth(frame.depth), "depth: no pixel has a depth", frame.depth);
  drop(!frame.descriptors.empty() && cv::countNonZero(frame.descriptors) == 0, "descriptors: all are zero",
       frame.descriptors);
  drop(frame.camera && !frame.camera->valid() && frame.camera->width_px == 0,
       "camera: neither a focal length nor a size", frame.camera);
  drop_empty_keyframes(frame);
}

inline bool FrameCleaner::has_depth(const cv::Mat& image) {
  const auto row_has = [&](int y) {
    if (image.type() == CV_16UC1) {
      const std::uint16_t* row = image.ptr<std::uint16_t>(y);
      return std::any_of(row, row + image.cols, [](std::uint16_t depth) { return depth != 0; });
    }
    const float* row = image.ptr<float>(y);
    return std::any_of(row, row + image.cols, valid_depth);
  };
  for (int y = 0; y < image.rows; ++y)
    if (row_has(y)) return true;
  return false;
}

inline void FrameCleaner::drop_empty_keyframes(FrameView& frame) {
  const auto usable = [](const KeyframeView& keyframe) {
    const bool empty = keyframe.keypoints_undistorted.empty() && keyframe.map_point_ids.empty();
    return !empty && is_rigid(keyframe.T_world_camera);
  };
  const Span<const KeyframeView> given = frame.covisible_keyframes;
  if (std::all_of(given.begin(), given.end(), usable)) return;
  keyframes_.clear();
  std::copy_if(given.begin(), given.end(), std::back_inserter(keyframes_), usable);
  notes_.push_back(std::to_string(given.size() - keyframes_.size()) + " of " + std::to_string(given.size()) +
                   " covisible keyframes cannot be used: empty, or the pose is not rigid");
  frame.covisible_keyframes = keyframes_;
}

inline bool FrameCleaner::clean_count(FrameView& frame) {
  const std::size_t n = frame.size();
  if (n <= limits::kMaxFeatures) return true;
  notes_.push_back(std::to_string(n) + " features, expected at most " + std::to_string(limits::kMaxFeatures) +
                   ": not judged");
  keypoints_.assign(n, cv::KeyPoint(kNone, kNone, 0));
  frame.keypoints = keypoints_;
  if (!frame.keypoints_undistorted.empty()) frame.keypoints_undistorted = keypoints_;
  return false;
}

inline void FrameCleaner::clean_places(FrameView& frame) {
  const Dropped dropped = clean_places(frame.keypoints, keypoints_);
  if (dropped.nowhere > 0)
    notes_.push_back(std::to_string(dropped.nowhere) + " keypoints are in no image: not judged");
  if (dropped.crowded > 0)
    notes_.push_back(std::to_string(dropped.crowded) + " keypoints are more than " +
                     std::to_string(limits::kMaxCrowd) + " in a square of " +
                     std::to_string(limits::kCrowd_px) + " px: not judged");
  clean_places(frame.keypoints_undistorted, undistorted_);
}

inline FrameCleaner::Dropped FrameCleaner::clean_places(Span<const cv::KeyPoint>& given,
                                                        std::vector<cv::KeyPoint>& own) {
  const auto odd = [](const cv::KeyPoint& keypoint) { return !PointGrid::usable(keypoint.pt); };
  const std::vector<std::uint32_t>& crowded = crowds_.find(given);
  const Dropped dropped{static_cast<std::size_t>(std::count_if(given.begin(), given.end(), odd)),
                        crowded.size()};
  if (dropped.nowhere + dropped.crowded == 0) return dropped;
  own.assign(given.begin(), given.end());
  for (cv::KeyPoint& keypoint : own)
    if (odd(keypoint)) keypoint.pt = {kNone, kNone};
  for (const std::uint32_t i : crowded) own[i].pt = {kNone, kNone};
  given = own;
  return dropped;
}

inline void FrameCleaner::clean_boxes(FrameView& frame) {
  if (!frame.detections) return;
  Span<const Detection>& given = frame.detections->detections;
  const auto usable = [](const Detection& box) { return is_usable(box); };
  const std::size_t most =
      std::min(limits::kMaxBoxes, limits::kMaxBoxFeaturePairs / std::max<std::size_t>(1, frame.size()));
  if (given.size() <= most && std::all_of(given.begin(), given.end(), usable)) return;
  keep_best(given, most);
  if (kept_.empty()) return frame.detections.reset();  // nothing is known, which is not "nothing was found"
  detections_.clear();
  for (const std::size_t k : kept_) {
    Detection box = given[k];
    if (!box.mask.empty() && box.mask.type() != CV_8UC1) box.mask = cv::Mat();
    box.box = *usable_box(given[k]);
    detections_.push_back(std::move(box));
  }
  given = detections_;
}

inline void FrameCleaner::keep_best(Span<const Detection> given, std::size_t most) {
  kept_.clear();
  for (std::size_t k = 0; k < given.size(); ++k)
    if (usable_box(given[k])) kept_.push_back(k);
  const std::string of_all = " of " + std::to_string(given.size()) + " boxes cannot be used";
  if (kept_.size() < given.size()) notes_.push_back(std::to_string(given.size() - kept_.size()) + of_all);
  if (kept_.size() <= most) return;
  notes_.push_back(std::to_string(kept_.size()) + " boxes: only the " + std::to_string(most) +
                   " with the highest scores are used");
  const auto first = kept_.begin() + static_cast<std::ptrdiff_t>(most);
  std::nth_element(kept_.begin(), first, kept_.end(), [&](std::size_t a, std::size_t b) {
    return std::tuple(-given[a].score, a) < std::tuple(-given[b].score, b);
  });
  kept_.erase(first, kept_.end());
  std::sort(kept_.begin(), kept_.end());
}

inline std::optional<cv::Rect2f> FrameCleaner::usable_box(const Detection& detection) {
  if (!(detection.score >= 0 && detection.score <= 1)) return std::nullopt;
  if (is_usable_box(detection.box)) return detection.box;
  const cv::Rect2f box = clipped(detection.box);
  if (!is_usable_box(box)) return std::nullopt;
  return box;
}

inline bool FrameCleaner::is_usable(const Detection& detection) {
  return is_usable_box(detection.box) && detection.score >= 0 && detection.score <= 1 &&
         (detection.mask.empty() || detection.mask.type() == CV_8UC1);
}

inline bool FrameCleaner::is_usable_box(const cv::Rect2f& box) {
  return box.width > 0 && box.height > 0 && PointGrid::usable(box.tl()) && PointGrid::usable(box.br());
}

inline cv::Rect2f FrameCleaner::clipped(const cv::Rect2f& box) {
  const auto within = [](float px) {
    constexpr float kMost = kMaxPixel / 2;
    return std::isnan(px) ? px : std::clamp(px, -kMost, kMost);
  };
  const float x = within(box.x), y = within(box.y);
  return {x, y, within(box.x + box.width) - x, within(box.y + box.height) - y};
}

inline bool FrameCleaner::is_usable(const Camera& camera) {
  const auto within = [](double value, double least) { return value >= least && value <= 1e6; };
  const bool only_size = camera.fx_px == 0 && camera.fy_px == 0 && !camera.distorted();
  // No image has a focal length below one pixel.
  bool all = (only_size || (within(camera.fx_px, 1) && within(camera.fy_px, 1))) &&
             within(camera.cx_px, -1e6) && within(camera.cy_px, -1e6) &&
             within(camera.baseline_fx_px_m, -1e6) && within(camera.width_px, 0) &&
             within(camera.height_px, 0);
  for (const double k : camera.distortion) all = all && within(k, -1e6);
  return all;
}

}  // namespace dynfilter
