// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/needs.hpp>
#include <dynfilter/evidence/clean_frame.hpp>
#include <dynfilter/evidence/crowded_places.hpp>
#include <opencv2/core/types.hpp>
#include <string>
#include <vector>

namespace dynfilter {

/// The frame as it came in, checked, and what is measured at each of its features alone: pixels, depths and
/// 3-D points, computed on first use.
class CurrentFrame {
 public:
  /// Depths beyond `max_depth_m` do not count, but for those of a stereo pair. `max_depth_edge`: see DepthSampler.
  CurrentFrame(double max_depth_m, double max_depth_edge)
      : max_depth_m_(max_depth_m), max_depth_edge_(max_depth_edge) {}

  void begin(const FrameView& frame);
  /// The host's memory is neither read nor referred to after this.
  void end() {
    frame_ = FrameView();
    cleaner_.end();
  }

  const FrameView& frame() const { return frame_; }
  Input inputs() const { return inputs_; }
  std::size_t size() const { return pixels_.size(); }
  /// Inputs that were present but unusable.
  const std::vector<std::string>& notes() const { return cleaner_.notes(); }

  const std::vector<cv::Point2f>& pixels() const { return pixels_; }
  const std::vector<cv::Point2f>& undistorted_pixels();
  const std::vector<float>& depths_m();
  const std::vector<cv::Point3f>& points_m();

  /// Of the grey image, else of the depth image, else of the camera.
  cv::Size image_size_px() const;

 private:
  void fill_undistorted();

  /// Depths of the host, except on silhouettes of the depth image.
  void fill_depths();
  /// From the columns in the right image, whatever `max_depth_m` says.
  void fill_stereo_depths();

  double max_depth_m_, max_depth_edge_;
  FrameCleaner cleaner_;
  CrowdedPlaces crowds_;
  FrameView frame_;
  Input inputs_ = Input::None;
  std::vector<cv::Point2f> pixels_, undistorted_;
  std::vector<float> depths_m_;
  std::vector<cv::Point3f> points_m_;
  bool undistorted_ready_ = false, depths_ready_ = false, points_ready_ = false;
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/evidence/detail/current_frame-inl.hpp>
#endif
