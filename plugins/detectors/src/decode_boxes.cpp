// SPDX-License-Identifier: MIT
#include <dynfilter/detectors/decode_boxes.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <opencv2/core.hpp>
#include <string>

namespace dynfilter {

void decode_yolo_regions(const cv::Mat& output, const BoxLayout& layout, std::vector<NetworkBox>& boxes) {
  const int columns = 5 + layout.classes;
  const bool flat =
      detail::is_float_tensor(output, 2) || (detail::is_float_tensor(output, 3) && output.size[0] == 1);
  if (!flat || output.size[output.dims - 1] != columns)
    detail::wrong_layout(output, "Nx" + std::to_string(columns) + " (a box, objectness, " +
                                     std::to_string(layout.classes) + " class scores)");
  const int rows = output.size[output.dims - 2];
  const auto width = static_cast<float>(layout.input.width), height = static_cast<float>(layout.input.height);
  for (int i = 0; i < rows; ++i) {
    const float* row = output.ptr<float>() + static_cast<std::ptrdiff_t>(i) * columns;
    const float* best = std::max_element(row + 5, row + columns);
    if (!(*best >= layout.min_score)) continue;
    detail::add_if_sound(
        {detail::centred_box(row[0] * width, row[1] * height, row[2] * width, row[3] * height),
         static_cast<int>(best - row - 5), *best, i},
        boxes);
  }
}

void decode_yolov5(const cv::Mat& output, const BoxLayout& layout, std::vector<NetworkBox>& boxes) {
  const int columns = 5 + layout.classes + layout.coefficients;
  if (!detail::is_float_tensor(output, 3) || output.size[0] != 1 || output.size[2] != columns)
    detail::wrong_layout(output, "1xNx" + std::to_string(columns) + " (a box, objectness, " +
                                     std::to_string(layout.classes) + " class scores" +
                                     (layout.coefficients > 0 ? ", mask coefficients)" : ")"));
  for (int i = 0; i < output.size[1]; ++i) {
    const float* row = output.ptr<float>() + static_cast<std::ptrdiff_t>(i) * columns;
    if (!(row[4] >= layout.min_score)) continue;
    const float* best = std::max_element(row + 5, row + 5 + layout.classes);
    const float score = row[4] * *best;
    if (!(score >= layout.min_score)) continue;
    detail::add_if_sound(
        {detail::centred_box(row[0], row[1], row[2], row[3]), static_cast<int>(best - row - 5), score, i},
        boxes);
  }
}

void decode_yolov8(const cv::Mat& output, const BoxLayout& layout, std::vector<NetworkBox>& boxes) {
  const int rows = 4 + layout.classes + layout.coefficients;
  if (!detail::is_float_tensor(output, 3) || output.size[0] != 1 || output.size[1] != rows)
    detail::wrong_layout(output, "1x" + std::to_string(rows) + "xN (a box, " +
                                     std::to_string(layout.classes) + " class scores" +
                                     (layout.coefficients > 0 ? ", mask coefficients)" : ")"));
  const int n = output.size[2];
  const auto row = [&](int r) { return output.ptr<float>() + static_cast<std::ptrdiff_t>(r) * n; };
  std::vector<float> best(row(4), row(4) + n);
  std::vector<int> label(best.size(), 0);
  for (int c = 1; c < layout.classes; ++c) {
    const float* scores = row(4 + c);
    for (int i = 0; i < n; ++i) {
      if (!(scores[i] > best[static_cast<std::size_t>(i)])) continue;
      best[static_cast<std::size_t>(i)] = scores[i];
      label[static_cast<std::size_t>(i)] = c;
    }
  }
  for (int i = 0; i < n; ++i) {
    const float score = best[static_cast<std::size_t>(i)];
    if (score >= layout.min_score)
      detail::add_if_sound({detail::centred_box(row(0)[i], row(1)[i], row(2)[i], row(3)[i]),
                            label[static_cast<std::size_t>(i)], score, i},
                           boxes);
  }
}

void decode_ssd(const cv::Mat& output, const BoxLayout& layout, std::vector<NetworkBox>& boxes) {
  if (!detail::is_float_tensor(output, 4) || output.size[0] != 1 || output.size[1] != 1 ||
      output.size[3] != 7)
    detail::wrong_layout(output, "1x1xNx7 (image, label, score, box)");
  const auto width = static_cast<float>(layout.input.width), height = static_cast<float>(layout.input.height);
  for (int i = 0; i < output.size[2]; ++i) {
    const float* row = output.ptr<float>() + static_cast<std::ptrdiff_t>(i) * 7;
    if (row[0] < 0) break;
    if (!(row[2] >= layout.min_score) || !(std::abs(row[1]) < 1e6F)) continue;
    const cv::Rect2f box(row[3] * width, row[4] * height, (row[5] - row[3]) * width,
                         (row[6] - row[4]) * height);
    detail::add_if_sound({box, cvRound(row[1]), row[2], i}, boxes);
  }
}

}  // namespace dynfilter
