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

/// One object as a network's output says it.
struct NetworkBox {
  cv::Rect2f box;   ///< pixels of the network's input
  int label = -1;   ///< the network's own number
  float score = 0;  ///< [0, 1]
  int anchor = -1;  ///< its row or column in the output, for the mask coefficients there
};

/// What a decoder of boxes must be told.
struct BoxLayout {
  cv::Size input;        ///< of the network [px]
  int classes = 0;       ///< the length of the class list
  int coefficients = 0;  ///< mask coefficients behind the class scores; 0: a network without masks
  float min_score = 0;   ///< boxes below are left out
};

namespace detail {

/// "1x84x8400".
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

/// Networks gone wrong give NaN and boxes of no size: left out.
inline void add_if_sound(const NetworkBox& box, std::vector<NetworkBox>& boxes) {
  const cv::Rect2f& b = box.box;
  if (b.width > 0 && b.height > 0 && std::isfinite(b.x) && std::isfinite(b.y) && std::isfinite(b.width) &&
      std::isfinite(b.height))
    boxes.push_back(box);
}

}  // namespace detail

inline float overlap_share(const cv::Rect2f& a, const cv::Rect2f& b) {
  const float both = (a & b).area();
  return both > 0 ? both / (a.area() + b.area() - both) : 0.0F;
}

/// Greedy non-maximum suppression within each class: the best first, of equal ones the earlier; what overlaps
/// a kept box of its class by more than `max_overlap` (intersection over union) goes.
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
