// SPDX-License-Identifier: MIT
#include <dynfilter/detectors/input_fit.hpp>

#include <opencv2/core.hpp>

namespace dynfilter {

InputFit InputFit::of(cv::Size image, cv::Size input, ImageFit how) {
  InputFit fit{image, input};
  fit.scale_x = static_cast<double>(input.width) / image.width;
  fit.scale_y = static_cast<double>(input.height) / image.height;
  if (how == ImageFit::Stretch) return fit;
  fit.scale_x = fit.scale_y = std::min(fit.scale_x, fit.scale_y);
  const cv::Rect area = fit.area();
  fit.offset_x_px = area.x;
  fit.offset_y_px = area.y;
  // The integer size that the image is resized to.
  fit.scale_x = static_cast<double>(area.width) / image.width;
  fit.scale_y = static_cast<double>(area.height) / image.height;
  return fit;
}

cv::Rect InputFit::area() const {
  const cv::Size size(std::clamp(cvRound(image.width * scale_x), 1, input.width),
                      std::clamp(cvRound(image.height * scale_y), 1, input.height));
  return {(input.width - size.width) / 2, (input.height - size.height) / 2, size.width, size.height};
}

cv::Rect2f InputFit::to_image(const cv::Rect2f& box) const {
  const auto x = [&](float at) {
    return clamped((static_cast<double>(at) - offset_x_px) / scale_x, image.width);
  };
  const auto y = [&](float at) {
    return clamped((static_cast<double>(at) - offset_y_px) / scale_y, image.height);
  };
  const float x0 = x(box.x), y0 = y(box.y);
  return {x0, y0, x(box.x + box.width) - x0, y(box.y + box.height) - y0};
}

}  // namespace dynfilter
