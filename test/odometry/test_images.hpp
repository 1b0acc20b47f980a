// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <random>

#include "io/sequence.hpp"

namespace odometry_test {

/// Rectangles of random size and grey: corners at many scales.
inline cv::Mat texture(cv::Size size, unsigned seed) {
  std::mt19937 random(seed);
  cv::Mat image(size, CV_8UC1, cv::Scalar(128));
  for (int i = 0; i < size.area() / 150; ++i) {
    const int w = 4 + static_cast<int>(random() % 40), h = 4 + static_cast<int>(random() % 40);
    const int x = static_cast<int>(random() % size.width) - w / 2,
              y = static_cast<int>(random() % size.height) - h / 2;
    cv::rectangle(image, {x, y, w, h}, cv::Scalar(static_cast<double>(random() % 256)), cv::FILLED);
  }
  cv::GaussianBlur(image, image, {3, 3}, 0.8);
  return image;
}

inline dynfilter::Camera camera() {
  dynfilter::Camera c;
  c.fx_px = c.fy_px = 525;
  c.cx_px = 319.5;
  c.cy_px = 239.5;
  c.width_px = 640;
  c.height_px = 480;
  return c;
}

/// A camera that looks along z at a textured relief: a wall at z = 2 m with a board at 1.6 m.
/// Both are parallel to the image. The camera is at (x, y, 0) and does not rotate. Exact depth.
inline dynfilter::io::SequenceFrame frame_at(double x_m, double y_m, double timestamp_s) {
  static const cv::Mat wall = texture({1400, 1200}, 11), board = texture({260, 260}, 12);
  const dynfilter::Camera c = camera();
  const double wall_m = 2.0, board_m = 1.6;
  dynfilter::io::SequenceFrame frame;
  frame.timestamp_s = timestamp_s;
  frame.depth_unit_m = 1.0 / 5000;
  const auto placed = [&](const cv::Mat& picture, double z_m, cv::Mat& out) {
    const double shift_x = c.cx_px - picture.cols / 2.0 - c.fx_px * x_m / z_m;
    const double shift_y = c.cy_px - picture.rows / 2.0 - c.fy_px * y_m / z_m;
    const cv::Matx23d A(1, 0, shift_x, 0, 1, shift_y);
    cv::warpAffine(picture, out, A, {640, 480}, cv::INTER_LINEAR, cv::BORDER_CONSTANT, cv::Scalar(0));
  };
  cv::Mat near_picture, near_mask;
  placed(wall, wall_m, frame.grey);
  placed(board, board_m, near_picture);
  placed(cv::Mat(board.size(), CV_8UC1, cv::Scalar(255)), board_m, near_mask);
  near_mask = near_mask > 127;
  near_picture.copyTo(frame.grey, near_mask);
  frame.depth = cv::Mat(480, 640, CV_16UC1, cv::Scalar(wall_m * 5000));
  frame.depth.setTo(cv::Scalar(board_m * 5000), near_mask);
  return frame;
}

}  // namespace odometry_test
