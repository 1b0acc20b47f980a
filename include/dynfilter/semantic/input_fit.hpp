// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <opencv2/core.hpp>

namespace dynfilter {

/// How an image is brought to a network's input size.
enum class ImageFit {
  Stretch,   ///< both sides on their own: the usual way of Darknet, SSD and DeepLab
  Letterbox  ///< one scale, the rest filled on both sides: YOLOv5 and later
};

/// Where an image lies in a network's input. Places are continuous: (0, 0) is the corner of the first pixel.
struct InputFit {
  cv::Size image, input;
  double scale_x = 1, scale_y = 1, offset_x_px = 0, offset_y_px = 0;  ///< input = scale * image + offset

  static InputFit of(cv::Size image, cv::Size input, ImageFit how) {
    InputFit fit{image, input};
    fit.scale_x = static_cast<double>(input.width) / image.width;
    fit.scale_y = static_cast<double>(input.height) / image.height;
    if (how == ImageFit::Stretch) return fit;
    fit.scale_x = fit.scale_y = std::min(fit.scale_x, fit.scale_y);
    const cv::Rect area = fit.area();
    fit.offset_x_px = area.x;
    fit.offset_y_px = area.y;
    // The whole pixels that the image is really resized to.
    fit.scale_x = static_cast<double>(area.width) / image.width;
    fit.scale_y = static_cast<double>(area.height) / image.height;
    return fit;
  }

  /// The pixels of the input that hold the image.
  cv::Rect area() const {
    const cv::Size size(std::clamp(cvRound(image.width * scale_x), 1, input.width),
                        std::clamp(cvRound(image.height * scale_y), 1, input.height));
    return {(input.width - size.width) / 2, (input.height - size.height) / 2, size.width, size.height};
  }

  /// A box of the input in pixels of the image, cut at its borders; may be empty.
  cv::Rect2f to_image(const cv::Rect2f& box) const {
    const auto x = [&](float at) {
      return clamped((static_cast<double>(at) - offset_x_px) / scale_x, image.width);
    };
    const auto y = [&](float at) {
      return clamped((static_cast<double>(at) - offset_y_px) / scale_y, image.height);
    };
    const float x0 = x(box.x), y0 = y(box.y);
    return {x0, y0, x(box.x + box.width) - x0, y(box.y + box.height) - y0};
  }

 private:
  static float clamped(double value, int size) {
    return static_cast<float>(std::clamp(value, 0.0, static_cast<double>(size)));
  }
};

}  // namespace dynfilter
