// SPDX-License-Identifier: MIT
#include "io/rectifier.hpp"

#include <Eigen/Geometry>
#include <dynfilter/core/error.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace dynfilter::io {

Rectifier::Rectifier(const RigCamera& left, const RigCamera& right) {
  constexpr double kLeastCosine = 0.7;  // 45 degrees
  const Eigen::Matrix3d R_left = left.T_body_camera.R(), R_right = right.T_body_camera.R();
  const Eigen::Vector3d baseline = right.T_body_camera.t() - left.T_body_camera.t();
  const Eigen::Vector3d x = baseline.normalized();
  if (!(baseline.norm() > 0) || x.dot(R_left.col(0)) < kLeastCosine || x.dot(R_right.col(0)) < kLeastCosine)
    throw IoError("the second camera is not to the right of the first one");
  if (R_left.col(2).dot(R_right.col(2)) < kLeastCosine)
    throw IoError("the cameras look in different directions");
  const Eigen::Vector3d ahead = R_left.col(2) + R_right.col(2);
  Eigen::Matrix3d R;
  R.col(0) = x;
  R.col(1) = ahead.cross(x).normalized();
  R.col(2) = x.cross(R.col(1));
  zoom(left, right, R);
  camera_.baseline_fx_px_m = camera_.fx_px * baseline.norm();
  T_body_camera_ = Pose::from(R, left.T_body_camera.t());
  left_map_ = map_of(left, R), right_map_ = map_of(right, R);
}

Eigen::Vector2d Rectifier::source_px(const Camera& original, const Camera& rectified,
                                     const Eigen::Matrix3d& R_original_rectified, double u_px, double v_px) {
  const Eigen::Vector3d p =
      R_original_rectified * Eigen::Vector3d((u_px - rectified.cx_px) / rectified.fx_px,
                                             (v_px - rectified.cy_px) / rectified.fy_px, 1);
  const double x = p.x() / p.z(), y = p.y() / p.z(), r2 = x * x + y * y;
  const auto& k = original.distortion;
  const double radial = 1 + r2 * (k[0] + r2 * (k[1] + r2 * k[4]));
  return {original.fx_px * (x * radial + 2 * k[2] * x * y + k[3] * (r2 + 2 * x * x)) + original.cx_px,
          original.fy_px * (y * radial + k[2] * (r2 + 2 * y * y) + 2 * k[3] * x * y) + original.cy_px};
}

inline void Rectifier::zoom(const RigCamera& left, const RigCamera& right,
                            const Eigen::Matrix3d& R_body_rectified) {
  camera_ = Camera();
  camera_.width_px = left.camera.width_px, camera_.height_px = left.camera.height_px;
  camera_.cx_px = 0.5 * (camera_.width_px - 1), camera_.cy_px = 0.5 * (camera_.height_px - 1);
  const auto fits = [&](double focal_px) {
    camera_.fx_px = camera_.fy_px = focal_px;
    return covers(left, camera_, R_body_rectified) && covers(right, camera_, R_body_rectified);
  };
  constexpr double kLargestZoom = 3;
  constexpr int kHalvings = 30;
  double empty = 0.3 * left.camera.fx_px, full = kLargestZoom * left.camera.fx_px;
  if (!fits(full)) throw IoError("the images of the two cameras do not overlap enough to be rectified");
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = 0.5 * (empty + full);
    (fits(middle) ? full : empty) = middle;
  }
  fits(full);
}

inline bool Rectifier::covers(const RigCamera& original, const Camera& rectified,
                              const Eigen::Matrix3d& R_body_rectified) {
  const Eigen::Matrix3d R = original.T_body_camera.R().transpose() * R_body_rectified;
  const auto inside = [&](int u, int v) {
    const Eigen::Vector2d px = source_px(original.camera, rectified, R, u, v);
    return px.x() >= 0 && px.y() >= 0 && px.x() <= original.camera.width_px - 1 &&
           px.y() <= original.camera.height_px - 1;
  };
  const int w = rectified.width_px - 1, h = rectified.height_px - 1;
  for (int u = 0; u <= w; ++u)
    if (!inside(u, 0) || !inside(u, h)) return false;
  for (int v = 0; v <= h; ++v)
    if (!inside(0, v) || !inside(w, v)) return false;
  return true;
}

inline cv::Mat Rectifier::map_of(const RigCamera& original, const Eigen::Matrix3d& R_body_rectified) const {
  const Eigen::Matrix3d R = original.T_body_camera.R().transpose() * R_body_rectified;
  cv::Mat map(camera_.height_px, camera_.width_px, CV_32FC2);
  for (int v = 0; v < map.rows; ++v)
    for (int u = 0; u < map.cols; ++u) {
      const Eigen::Vector2f px = source_px(original.camera, camera_, R, u, v).cast<float>();
      map.at<cv::Vec2f>(v, u) = {px.x(), px.y()};
    }
  return map;
}

cv::Mat Rectifier::warped(const cv::Mat& image, const cv::Mat& map) {
  cv::Mat result;
  cv::remap(image, result, map, cv::noArray(), cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  return result;
}

}  // namespace dynfilter::io
