// SPDX-License-Identifier: MIT
#pragma once

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

[[noreturn]] void wrong_layout(const cv::Mat& tensor, const std::string& expected);

inline bool is_float_tensor(const cv::Mat& tensor, int dims) {
  return tensor.dims == dims && tensor.type() == CV_32FC1 && tensor.isContinuous();
}

inline cv::Rect2f centred_box(float x, float y, float width, float height) {
  return {x - width / 2, y - height / 2, width, height};
}

/// Appends the box unless it has NaN or no area.
void add_if_sound(const NetworkBox& box, std::vector<NetworkBox>& boxes);

}  // namespace detail

/// Intersection over union, in [0, 1].
float overlap_share(const cv::Rect2f& a, const cv::Rect2f& b);

/// Greedy non-maximum suppression within each class, highest score first, then by order.
/// Removes boxes that overlap a kept box of their class by more than `max_overlap` (intersection over union).
void suppress_doubles(std::vector<NetworkBox>& boxes, float max_overlap);

}  // namespace dynfilter
