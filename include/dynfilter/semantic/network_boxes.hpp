// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <dynfilter/core/error.hpp>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace dynfilter {

/// One object in a network's output.
struct NetworkBox {
  cv::Rect2f box;   ///< pixels of the network's input
  int label = -1;   ///< label of the network
  float score = 0;  ///< [0, 1]
  int anchor = -1;  ///< row or column in the output, which contains the mask coefficients
};

/// Input of a decoder of boxes.
struct BoxLayout {
  cv::Size input;        ///< input size of the network [px]
  int classes = 0;       ///< length of the class list
  int coefficients = 0;  ///< mask coefficients after the class scores; 0: no masks
  float min_score = 0;   ///< smallest score of a box that is used
};

namespace detail {

/// Shape such as "1x84x8400".
inline std::string shape_text(const cv::Mat& tensor) {
  std::string text;
  for (int i = 0; i < tensor.dims; ++i) text += (i > 0 ? "x" : "") + std::to_string(tensor.size[i]);
  return text.empty() ? "nothing" : text;
}

[[noreturn]] inline void wrong_layout(const cv::Mat& tensor, const std::string& expected) {
  throw Error("its output is " + shape_text(tensor) +
              (tensor.type() == CV_32FC1 ? "" : " and not of single floats") + ", expected " + expected);
}

inline bool is_float_tensor(const cv::Mat& tensor, int dims) {
  return tensor.dims == dims && tensor.type() == CV_32FC1 && tensor.isContinuous();
}

inline cv::Rect2f centred_box(float x, float y, float width, float height) {
  return {x - width / 2, y - height / 2, width, height};
}

/// Appends the box unless it has NaN or no area.
inline void add_if_sound(const NetworkBox& box, std::vector<NetworkBox>& boxes) {
  const cv::Rect2f& b = box.box;
  if (b.width > 0 && b.height > 0 && std::isfinite(b.x) && std::isfinite(b.y) && std::isfinite(b.width) &&
      std::isfinite(b.height))
    boxes.push_back(box);
}

}  // namespace detail

/// Intersection over union, in [0, 1].
inline float overlap_share(const cv::Rect2f& a, const cv::Rect2f& b) {
  const float both = (a & b).area();
  return both > 0 ? both / (a.area() + b.area() - both) : 0.0F;
}

/// Greedy non-maximum suppression within each class, highest score first, then by order.
/// Removes boxes that overlap a kept box of their class by more than `max_overlap`
/// (intersection over union).
inline void suppress_doubles(std::vector<NetworkBox>& boxes, float max_overlap) {
  std::stable_sort(boxes.begin(), boxes.end(),
                   [](const NetworkBox& a, const NetworkBox& b) { return a.score > b.score; });
  std::vector<NetworkBox> kept;
  for (const NetworkBox& box : boxes) {
    const bool is_double = std::any_of(kept.begin(), kept.end(), [&](const NetworkBox& better) {
      return better.label == box.label && overlap_share(better.box, box.box) > max_overlap;
    });
    if (!is_double) kept.push_back(box);
  }
  boxes = std::move(kept);
}

}  // namespace dynfilter
