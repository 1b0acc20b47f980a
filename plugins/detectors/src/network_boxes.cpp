// SPDX-License-Identifier: MIT
#include <dynfilter/detectors/network_boxes.hpp>

#include <algorithm>
#include <cmath>
#include <dynfilter/core/error.hpp>
#include <utility>

namespace dynfilter {

namespace detail {

/// Shape such as "1x84x8400".
inline std::string shape_text(const cv::Mat& tensor) {
  std::string text;
  for (int i = 0; i < tensor.dims; ++i) text += (i > 0 ? "x" : "") + std::to_string(tensor.size[i]);
  return text.empty() ? "nothing" : text;
}

void wrong_layout(const cv::Mat& tensor, const std::string& expected) {
  throw Error("its output is " + shape_text(tensor) +
              (tensor.type() == CV_32FC1 ? "" : " and not of single floats") + ", expected " + expected);
}

void add_if_sound(const NetworkBox& box, std::vector<NetworkBox>& boxes) {
  const cv::Rect2f& b = box.box;
  if (b.width > 0 && b.height > 0 && std::isfinite(b.x) && std::isfinite(b.y) && std::isfinite(b.width) &&
      std::isfinite(b.height))
    boxes.push_back(box);
}

}  // namespace detail

float overlap_share(const cv::Rect2f& a, const cv::Rect2f& b) {
  const float both = (a & b).area();
  return both > 0 ? both / (a.area() + b.area() - both) : 0.0F;
}

void suppress_doubles(std::vector<NetworkBox>& boxes, float max_overlap) {
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
