// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <opencv2/core/types.hpp>

namespace dynfilter {

/// How an image is scaled to a network's input size.
enum class ImageFit {
  Stretch,   ///< scales both sides independently; used by Darknet, SSD and DeepLab
  Letterbox  ///< uses one scale and fills the rest on both sides; used by YOLOv5 and later
};

/// Position of an image in a network's input.
/// Coordinates are continuous: (0, 0) is the corner of the first pixel.
struct InputFit {
  cv::Size image, input;
  /// Input = scale * image + offset.
  double scale_x = 1, scale_y = 1, offset_x_px = 0, offset_y_px = 0;

  /// Where the image is in the input, both in pixels.
  static InputFit of(cv::Size image, cv::Size input, ImageFit how);

  /// The pixels of the input that contain the image.
  cv::Rect area() const;

  /// Converts a box of the input to pixels of the image and clips it. The result may be empty.
  cv::Rect2f to_image(const cv::Rect2f& box) const;

 private:
  static float clamped(double value, int size) {
    return static_cast<float>(std::clamp(value, 0.0, static_cast<double>(size)));
  }
};

}  // namespace dynfilter
