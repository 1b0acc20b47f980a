// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/detection.hpp>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/point_grid.hpp>
#include <dynfilter/core/span.hpp>
#include <dynfilter/evidence/crowded_places.hpp>
#include <limits>
#include <opencv2/core/types.hpp>
#include <optional>
#include <string>
#include <vector>

namespace dynfilter {

/// Cleans a host's frame once, so that filters need no checks of their own.
/// Afterwards these hold:
///  - arrays are empty or as long as the keypoints;
///  - an input that is there has a usable value (hosts fill what they lack: ORB-SLAM has N times -1);
///  - images have a supported type;
///  - a camera has a focal length, or only an image size (focal lengths 0, no distortion);
///  - a pose is rigid;
///  - boxes have an area and a score in [0, 1], and there are at most limits::kMaxBoxes, or fewer with many
///    features (limits::kMaxBoxFeaturePairs);
///  - pixel positions are NaN or within 1e6 pixels, and at most limits::kMaxCrowd are in a square of
///    limits::kCrowd_px.
/// Of more boxes those with the highest scores are kept.
/// Of more than limits::kMaxFeatures features none is judged, and none of those in a more crowded square.
/// Unusable input is removed, with a note. So is an input without a usable value, as if it had not been given:
/// without a note where hosts fill arrays with "none" (depths, right columns, map points, matches).
/// An unusual array is replaced by a copy in this object, valid until the next call.
class FrameCleaner {
 public:
  void clean(FrameView& frame);
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
  static bool sound(const Detection& detection);
  static bool sound_box(const cv::Rect2f& box);
  /// Clips a box that reaches far beyond the image, so that its part in the image remains.
  static cv::Rect2f clipped(const cv::Rect2f& box);
  /// The box as filters may use it, or nullopt.
  static std::optional<cv::Rect2f> usable_box(const Detection& detection);
  /// Keeps `most` boxes with the highest scores in kept_, in the order given.
  void keep_best(Span<const Detection> given, std::size_t most);

  static bool sound(const Camera& camera);

  std::vector<std::string> notes_;
  CrowdedPlaces crowds_;
  std::vector<cv::KeyPoint> keypoints_, undistorted_;
  std::vector<Detection> detections_;
  std::vector<KeyframeView> keyframes_;
  std::vector<std::size_t> kept_;
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/evidence/detail/clean_frame-inl.hpp>
#endif
