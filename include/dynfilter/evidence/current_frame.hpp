// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstddef>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/needs.hpp>
#include <dynfilter/core/span.hpp>
#include <dynfilter/evidence/clean_frame.hpp>
#include <dynfilter/geometry/depth_sampler.hpp>
#include <dynfilter/geometry/undistort.hpp>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace dynfilter {

/// The frame as it came in, checked, and what is measured at each of its features alone: pixels, depths and
/// 3-D points, computed on first use.
class CurrentFrame {
 public:
  /// Depths beyond `max_depth_m` do not count. `max_depth_edge`: see DepthSampler.
  CurrentFrame(double max_depth_m, double max_depth_edge)
      : max_depth_m_(max_depth_m), max_depth_edge_(max_depth_edge) {}

  void begin(const FrameView& frame) {
    frame_ = frame;
    cleaner_.clean(frame_);
    inputs_ = inputs_of(frame_);
    pixels_.resize(frame_.size());
    for (std::size_t i = 0; i < pixels_.size(); ++i) pixels_[i] = frame_.keypoints[i].pt;
    undistorted_ready_ = depths_ready_ = points_ready_ = false;
  }
  /// The host's memory is not read after this.
  void end() { frame_ = FrameView(); }

  const FrameView& frame() const { return frame_; }
  Input inputs() const { return inputs_; }
  std::size_t size() const { return pixels_.size(); }
  /// Inputs that were present but unusable.
  const std::vector<std::string>& notes() const { return cleaner_.notes(); }

  const std::vector<cv::Point2f>& pixels() const { return pixels_; }
  const std::vector<cv::Point2f>& undistorted_pixels() {
    if (!undistorted_ready_) fill_undistorted();
    return undistorted_;
  }
  const std::vector<float>& depths_m() {
    if (!depths_ready_) fill_depths();
    return depths_m_;
  }
  const std::vector<cv::Point3f>& points_m() {
    if (!points_ready_) {
      points_m_.resize(size());
      back_project(frame_.camera.value_or(Camera()), undistorted_pixels(), depths_m(), points_m_);
      points_ready_ = true;
    }
    return points_m_;
  }

  /// Of the grey image, else of the depth image, else of the camera.
  cv::Size image_size_px() const {
    if (!frame_.grey.empty()) return frame_.grey.size();
    if (!frame_.depth.empty()) return frame_.depth.size();
    return frame_.camera ? cv::Size(frame_.camera->width_px, frame_.camera->height_px) : cv::Size();
  }

 private:
  void fill_undistorted() {
    undistorted_.resize(size());
    if (!frame_.keypoints_undistorted.empty())
      for (std::size_t i = 0; i < size(); ++i) undistorted_[i] = frame_.keypoints_undistorted[i].pt;
    else
      undistort_points(frame_.camera.value_or(Camera()), pixels_, undistorted_);
    undistorted_ready_ = true;
  }

  /// Depths of the host, except on silhouettes of the depth image.
  void fill_depths() {
    depths_m_.assign(size(), DepthSampler::kNone);
    const DepthSampler image(frame_.depth, frame_.depth_unit_m, max_depth_edge_);
    image.at_all(pixels_, [&](std::size_t i, float in_image) {
      const float seen = frame_.depth.empty() ? 0.0F : in_image;
      const float given = frame_.depth_m.empty() ? seen : frame_.depth_m[i];
      depths_m_[i] = std::isnan(seen) ? DepthSampler::kNone : depth_within(given, max_depth_m_);
    });
    depths_ready_ = true;
  }

  double max_depth_m_, max_depth_edge_;
  FrameCleaner cleaner_;
  FrameView frame_;
  Input inputs_ = Input::None;
  std::vector<cv::Point2f> pixels_, undistorted_;
  std::vector<float> depths_m_;
  std::vector<cv::Point3f> points_m_;
  bool undistorted_ready_ = false, depths_ready_ = false, points_ready_ = false;
};

}  // namespace dynfilter
