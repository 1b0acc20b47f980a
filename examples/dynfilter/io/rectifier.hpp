// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/pose.hpp>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>

namespace dynfilter::io {

/// One camera of a rig.
struct RigCamera {
  Camera camera;
  Pose T_body_camera;
};

/// Rectifies the images of a stereo pair: no distortion, parallel rows, one focal length.
/// The rows follow the baseline, the optical axis is the mean of both (Fusiello et al., MVA 2000).
/// The focal length is the smallest one without empty pixels in either image.
/// Cost: about 2 ms per image of 752 x 480.
class Rectifier {
 public:
  /// Both cameras must have an image size.
  /// Throws IoError if the right camera is not to the right of the left one, or if both look in directions
  /// too different.
  Rectifier(const RigCamera& left, const RigCamera& right);

  /// Of both rectified images, with the baseline.
  const Camera& camera() const { return camera_; }
  /// Of the rectified left camera.
  const Pose& T_body_camera() const { return T_body_camera_; }

  cv::Mat left(const cv::Mat& image) const { return warped(image, left_map_); }
  cv::Mat right(const cv::Mat& image) const { return warped(image, right_map_); }

  /// Pixel of the original image for a pixel of the rectified one.
  static Eigen::Vector2d source_px(const Camera& original, const Camera& rectified,
                                   const Eigen::Matrix3d& R_original_rectified, double u_px, double v_px);

 private:
  void zoom(const RigCamera& left, const RigCamera& right, const Eigen::Matrix3d& R_body_rectified);

  static bool covers(const RigCamera& original, const Camera& rectified,
                     const Eigen::Matrix3d& R_body_rectified);

  cv::Mat map_of(const RigCamera& original, const Eigen::Matrix3d& R_body_rectified) const;

  static cv::Mat warped(const cv::Mat& image, const cv::Mat& map);

  Camera camera_;
  Pose T_body_camera_;
  cv::Mat left_map_, right_map_;  // CV_32FC2
};

}  // namespace dynfilter::io
