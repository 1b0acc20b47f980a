// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstddef>
#include <dynfilter/core/frame_inputs.hpp>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/needs.hpp>
#include <dynfilter/correspondence/row_search.hpp>
#include <dynfilter/evidence/clean_frame.hpp>
#include <dynfilter/evidence/crowded_places.hpp>
#include <dynfilter/geometry/depth_noise.hpp>
#include <dynfilter/geometry/depth_sampler.hpp>
#include <dynfilter/geometry/undistort.hpp>
#include <limits>
#include <opencv2/core.hpp>
#include <string>
#include <utility>
#include <vector>

namespace dynfilter {

/// The frame as it came in, checked. Pixels, depths and 3-D points of each feature are computed on first use.
class CurrentFrame {
 public:
  /// Depths beyond `max_depth_m` count only from a stereo pair. `max_depth_edge`: see DepthSampler.
  CurrentFrame(double max_depth_m, double max_depth_edge)
      : max_depth_m_(max_depth_m), max_depth_edge_(max_depth_edge) {}

  void begin(const FrameView& frame);
  /// The host's memory is neither read nor referred to after this.
  void end() {
    frame_ = FrameView();
    cleaner_.end();
  }

  const FrameView& frame() const { return frame_; }  ///< as it was checked; valid until end()
  Input inputs() const { return inputs_; }           ///< inputs that are there and can be used
  std::size_t size() const { return pixels_.size(); }
  /// Inputs that were present but unusable.
  const std::vector<std::string>& notes() const { return cleaner_.notes(); }

  const std::vector<cv::Point2f>& pixels() const { return pixels_; }  ///< distorted [px]; NaN: in no image
  const std::vector<cv::Point2f>& undistorted_pixels();  ///< [px]: the host's, else computed with the camera
  const std::vector<float>& depths_m();                  ///< along the optical axis [m]; NaN: none
  int left_brighter() const { return left_brighter_; }   ///< RowSearch::left_brighter(), after depths_m()
  const std::vector<cv::Point3f>& points_m();  ///< in the frame of the camera [m]; NaN without depth

  void forget_columns() { searched_px_.clear(); }  ///< of the right image, which is another one

 private:
  void fill_undistorted();
  /// Depths of the host, except on silhouettes of the depth image.
  void fill_depths();
  /// From the right image, whatever `max_depth_m` says.
  void fill_stereo_depths();

  double max_depth_m_, max_depth_edge_;
  FrameCleaner cleaner_;
  CrowdedPlaces crowds_;
  FrameView frame_;
  Input inputs_ = Input::None;
  std::vector<cv::Point2f> pixels_, undistorted_;
  std::vector<float> depths_m_;
  std::vector<cv::Point3f> points_m_;
  int left_brighter_ = 0;
  // Of the last features of this frame: those of a later call point are some of them, in their order.
  std::vector<cv::Point2f> searched_px_;
  std::vector<float> columns_, known_columns_;
  bool undistorted_ready_ = false, depths_ready_ = false, points_ready_ = false;
};

inline void CurrentFrame::begin(const FrameView& frame) {
  frame_ = frame;
  cleaner_.clean(frame_);
  inputs_ = inputs_of(frame_);
  pixels_.resize(frame_.size());
  for (std::size_t i = 0; i < pixels_.size(); ++i) pixels_[i] = frame_.keypoints[i].pt;
  undistorted_ready_ = depths_ready_ = points_ready_ = false;
}

inline const std::vector<cv::Point2f>& CurrentFrame::undistorted_pixels() {
  if (!undistorted_ready_) fill_undistorted();
  return undistorted_;
}

inline const std::vector<float>& CurrentFrame::depths_m() {
  if (!depths_ready_) fill_depths();
  return depths_m_;
}

inline const std::vector<cv::Point3f>& CurrentFrame::points_m() {
  if (!points_ready_) {
    points_m_.resize(size());
    back_project(frame_.camera.value_or(Camera()), undistorted_pixels(), depths_m(), points_m_);
    points_ready_ = true;
  }
  return points_m_;
}

inline void CurrentFrame::fill_undistorted() {
  undistorted_ready_ = true;
  undistorted_.resize(size());
  if (!frame_.keypoints_undistorted.empty()) {
    for (std::size_t i = 0; i < size(); ++i) undistorted_[i] = frame_.keypoints_undistorted[i].pt;
    return;
  }
  const Camera camera = frame_.camera.value_or(Camera());
  undistort_points(camera, pixels_, undistorted_);
  if (!camera.distorted()) return;
  // A lens may draw them together.
  for (const std::uint32_t i : crowds_.find(Span<const cv::Point2f>(undistorted_)))
    undistorted_[i].x = undistorted_[i].y = std::numeric_limits<float>::quiet_NaN();
}

inline void CurrentFrame::fill_depths() {
  if (is_stereo(frame_)) return fill_stereo_depths();
  depths_m_.assign(size(), DepthSampler::kNone);
  const DepthSampler image(frame_.depth, frame_.depth_unit_m, max_depth_edge_);
  image.at_all(pixels_, [&](std::size_t i, float in_image) {
    const float seen = frame_.depth.empty() ? 0.0F : in_image;
    const float given = frame_.depth_m.empty() ? seen : frame_.depth_m[i];
    depths_m_[i] = std::isnan(seen) ? DepthSampler::kNone : depth_within(given, max_depth_m_);
  });
  depths_ready_ = true;
}

inline void CurrentFrame::fill_stereo_depths() {
  const std::vector<cv::Point2f>& undistorted = undistorted_pixels();
  depths_m_.resize(size());
  if (searched_px_.empty()) left_brighter_ = RowSearch::left_brighter(frame_.grey, frame_.right_grey);
  const RowSearch search(frame_.grey, frame_.right_grey, left_brighter_);
  std::swap(columns_, known_columns_);
  columns_.assign(size(), DepthSampler::kNone);
  for (std::size_t i = 0, known = 0; i < size(); ++i) {
    float right_u_px = frame_.right_u_px.empty() ? DepthSampler::kNone : frame_.right_u_px[i];
    while (known < searched_px_.size() && searched_px_[known] != pixels_[i]) ++known;
    if (!valid_right(right_u_px) && !frame_.right_grey.empty())
      right_u_px = columns_[i] =
          known < searched_px_.size() ? known_columns_[known] : search.column(pixels_[i]);
    depths_m_[i] = stereo_depth_m(undistorted[i].x, right_u_px, frame_.camera->baseline_fx_px_m);
  }
  searched_px_ = pixels_;
  depths_ready_ = true;
}

}  // namespace dynfilter
