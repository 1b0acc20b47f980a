// SPDX-License-Identifier: MIT
#include <dynfilter/detectors/decode_masks.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <dynfilter/detectors/network_boxes.hpp>
#include <opencv2/core.hpp>
#include <string>

namespace dynfilter {

void decode_class_scores(const cv::Mat& output, int classes, float min_foreground, float foreground_bias,
                         cv::Mat& labels) {
  if (!detail::is_float_tensor(output, 4) || output.size[0] != 1 || output.size[1] != classes ||
      classes > 255)
    detail::wrong_layout(output, "1x" + std::to_string(classes) + "xHxW (a score map for each of " +
                                     std::to_string(classes) + " classes, at most 255)");
  const std::size_t n = static_cast<std::size_t>(output.size[2]) * static_cast<std::size_t>(output.size[3]);
  labels.create(output.size[2], output.size[3], CV_8UC1);
  labels.setTo(0);
  std::uint8_t* label = labels.data;
  const float* scores = output.ptr<float>();
  if (classes == 1) {
    for (std::size_t i = 0; i < n; ++i) label[i] = scores[i] > min_foreground ? 1 : 0;
    return;
  }
  std::vector<float> best(scores, scores + n);
  for (float& score : best) score -= foreground_bias;
  for (int c = 1; c < classes; ++c) {
    scores += n;
    for (std::size_t i = 0; i < n; ++i) {
      if (!(scores[i] > best[i])) continue;
      best[i] = scores[i];
      label[i] = static_cast<std::uint8_t>(c);
    }
  }
}

cv::Mat image_part(const cv::Mat& labels, const InputFit& fit) {
  const cv::Rect area = fit.area();
  const double sx = static_cast<double>(labels.cols) / fit.input.width;
  const double sy = static_cast<double>(labels.rows) / fit.input.height;
  const int x0 = std::min(cvRound(area.x * sx), labels.cols - 1),
            y0 = std::min(cvRound(area.y * sy), labels.rows - 1);
  const int x1 = std::clamp(cvRound(area.br().x * sx), x0 + 1, labels.cols);
  const int y1 = std::clamp(cvRound(area.br().y * sy), y0 + 1, labels.rows);
  return labels(cv::Rect(x0, y0, x1 - x0, y1 - y0));
}

PrototypeMasks::PrototypeMasks(const cv::Mat& prototypes) : prototypes_(prototypes) {
  if (!detail::is_float_tensor(prototypes, 4) || prototypes.size[0] != 1)
    detail::wrong_layout(prototypes, "1xKxHxW mask prototypes");
}

cv::Mat PrototypeMasks::mask(const std::vector<float>& coefficients, const cv::Rect2f& box,
                             const InputFit& fit) {
  combine(coefficients);
  cv::Mat mask = cv::Mat::zeros(fit.image, CV_8UC1);
  const int x0 = std::max(cvRound(box.x), 0), x1 = std::min(cvRound(box.x + box.width), fit.image.width);
  const int y0 = std::max(cvRound(box.y), 0), y1 = std::min(cvRound(box.y + box.height), fit.image.height);
  const double sx = static_cast<double>(sum_.cols) / fit.input.width;
  const double sy = static_cast<double>(sum_.rows) / fit.input.height;
  for (int y = y0; y < y1; ++y) {
    const auto v = static_cast<float>(((y + 0.5) * fit.scale_y + fit.offset_y_px) * sy - 0.5);
    auto* row = mask.ptr<std::uint8_t>(y);
    for (int x = x0; x < x1; ++x) {
      const auto u = static_cast<float>(((x + 0.5) * fit.scale_x + fit.offset_x_px) * sx - 0.5);
      row[x] = bilinear(u, v) > 0 ? 255 : 0;
    }
  }
  return mask;
}

inline void PrototypeMasks::combine(const std::vector<float>& coefficients) {
  sum_.create(prototypes_.size[2], prototypes_.size[3], CV_32FC1);
  sum_.setTo(0);
  const std::size_t n = sum_.total();
  auto* sum = sum_.ptr<float>();
  for (std::size_t k = 0; k < coefficients.size(); ++k) {
    const float* prototype = prototypes_.ptr<float>() + k * n;
    for (std::size_t i = 0; i < n; ++i) sum[i] += coefficients[k] * prototype[i];
  }
}

inline float PrototypeMasks::bilinear(float u, float v) const {
  u = std::clamp(u, 0.0F, static_cast<float>(sum_.cols - 1));
  v = std::clamp(v, 0.0F, static_cast<float>(sum_.rows - 1));
  const int x = std::min(static_cast<int>(u), std::max(sum_.cols - 2, 0));
  const int y = std::min(static_cast<int>(v), std::max(sum_.rows - 2, 0));
  const int right = std::min(x + 1, sum_.cols - 1), below = std::min(y + 1, sum_.rows - 1);
  const float a = u - static_cast<float>(x), b = v - static_cast<float>(y);
  const auto* upper = sum_.ptr<float>(y);
  const auto* lower = sum_.ptr<float>(below);
  return (1 - b) * ((1 - a) * upper[x] + a * upper[right]) + b * ((1 - a) * lower[x] + a * lower[right]);
}

std::vector<float> mask_coefficients(const cv::Mat& output, int anchor, int coefficients, bool in_columns) {
  const int rows = output.size[1], columns = output.size[2];
  std::vector<float> values;
  for (int k = 0; k < coefficients; ++k) {
    const std::ptrdiff_t at =
        in_columns ? static_cast<std::ptrdiff_t>(rows - coefficients + k) * columns + anchor
                   : static_cast<std::ptrdiff_t>(anchor) * columns + columns - coefficients + k;
    values.push_back(output.ptr<float>()[at]);
  }
  return values;
}

}  // namespace dynfilter
