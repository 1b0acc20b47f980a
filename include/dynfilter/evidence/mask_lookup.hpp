// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <dynfilter/core/frame_view.hpp>
#include <opencv2/core.hpp>
#include <vector>

namespace dynfilter {

/// Size of the frame's images [px]. 0 x 0 if unknown.
cv::Size image_size(const FrameView& frame);

/// Point queries on a mask or label image of any size, in pixels of the frame's image.
/// Copies and dilates nothing. A neighbourhood query reads only that neighbourhood, eight pixels at a time.
class MaskLookup {
 public:
  MaskLookup() = default;
  /// `labels`: CV_8UC1; any other type is an empty mask. `image`: size of the image that it covers; 0 x 0:
  /// its own size. `wanted`: labels that count; empty: all except 0.
  MaskLookup(const cv::Mat& labels, cv::Size image, const std::vector<int>& wanted = {});

  bool empty() const { return labels_.data == nullptr; }
  /// Whether pixels of this label are on the mask.
  bool counts(std::uint8_t label) const { return wanted_[label]; }
  /// True if this pixel is on the mask. False outside the image.
  /// A keypoint at x = width belongs to the last column.
  bool at(const cv::Point2f& px) const;
  /// True if the mask has a pixel within this distance. Equal to at() on a mask dilated with a disc.
  bool near(const cv::Point2f& px, double radius_px) const;
  /// Visits the pixel, then the parts inside a disc around it of those rows that have the mask nearby.
  /// Calls f(row, from, to) with inclusive columns until it returns true. Returns the last result.
  template <class F>
  bool any_chord(const cv::Point2f& px, double radius_px, const F& f) const;
  const cv::Mat& labels() const { return labels_; }  ///< as they were given, CV_8UC1

 private:
  static constexpr double kRounding = 1e-6;

  bool inside(const cv::Point2f& px) const {
    return !empty() && px.x >= -0.5F && px.y >= -0.5F && static_cast<double>(px.x) <= width_px_ &&
           static_cast<double>(px.y) <= height_px_;
  }
  /// Of a pixel that is inside, rounded.
  int row_of(float y) const {
    return std::min(static_cast<int>((rounded(y) + 0.5) * scale_y_), labels_.rows - 1);
  }
  int column_of(float x) const {
    return std::min(static_cast<int>((rounded(x) + 0.5) * scale_x_), labels_.cols - 1);
  }
  static int rounded(float inside) {
    const double next = static_cast<double>(inside) + 0.5;  // not negative
    return static_cast<int>(next);
  }
  static int first_within(double at, int size) {
    at = std::clamp(at - kRounding, 0.0, static_cast<double>(size));
    const int before = static_cast<int>(at);
    return before + (before < at ? 1 : 0);
  }
  static int last_within(double at, int size) {
    return static_cast<int>(std::clamp(at + kRounding, -1.0, size - 1.0) + 1) - 1;
  }
  bool any(int row, int from, int to) const;

  cv::Mat labels_;
  double scale_x_ = 1, scale_y_ = 1, width_px_ = 0, height_px_ = 0;
  std::array<bool, 256> wanted_{};
};

template <class F>
bool MaskLookup::any_chord(const cv::Point2f& px, double radius_px, const F& f) const {
  if (empty() || !std::isfinite(px.x) || !std::isfinite(px.y)) return false;
  if (inside(px)) {
    const int column = column_of(px.x);
    if (f(row_of(px.y), column, column)) return true;
  }
  if (!(radius_px > 0)) return false;
  const double x = std::round(static_cast<double>(px.x)), y = std::round(static_cast<double>(px.y));
  const int first = first_within((y - radius_px + 0.5) * scale_y_ - 0.5, labels_.rows);
  const int last = last_within((y + radius_px + 0.5) * scale_y_ - 0.5, labels_.rows);
  const auto columns = [&](double half) {
    return std::array<int, 2>{first_within((x - half + 0.5) * scale_x_ - 0.5, labels_.cols),
                              last_within((x + half + 0.5) * scale_x_ - 0.5, labels_.cols)};
  };
  const auto [left, right] = columns(radius_px);
  for (int row = first; row <= last; ++row) {
    if (left > right || !any(row, left, right)) continue;  // a row of the square costs less than a chord
    const double dy = (row + 0.5) / scale_y_ - 0.5 - y;
    const double half = std::sqrt(std::max(0.0, radius_px * radius_px - dy * dy));
    const auto [from, to] = columns(half);
    if (from <= to && f(row, from, to)) return true;
  }
  return false;
}

inline cv::Size image_size(const FrameView& frame) {
  if (!frame.grey.empty()) return frame.grey.size();
  if (!frame.depth.empty()) return frame.depth.size();
  return frame.camera ? cv::Size(frame.camera->width_px, frame.camera->height_px) : cv::Size();
}

inline MaskLookup::MaskLookup(const cv::Mat& labels, cv::Size image, const std::vector<int>& wanted) {
  if (labels.empty() || labels.type() != CV_8UC1) return;
  labels_ = labels;
  if (image.width <= 0 || image.height <= 0) image = labels.size();
  scale_x_ = static_cast<double>(labels.cols) / image.width;
  scale_y_ = static_cast<double>(labels.rows) / image.height;
  width_px_ = image.width;
  height_px_ = image.height;
  wanted_.fill(wanted.empty());
  wanted_[0] = false;
  for (const int label : wanted)
    if (label >= 0 && label < 256) wanted_[static_cast<std::size_t>(label)] = true;
}

inline bool MaskLookup::at(const cv::Point2f& px) const {
  if (!inside(px)) return false;
  return counts(labels_.at<std::uint8_t>(row_of(px.y), column_of(px.x)));
}

inline bool MaskLookup::near(const cv::Point2f& px, double radius_px) const {
  return any_chord(px, radius_px, [&](int row, int from, int to) { return any(row, from, to); });
}

inline bool MaskLookup::any(int row, int from, int to) const {
  const std::uint8_t* pixels = labels_.ptr<std::uint8_t>(row);
  const auto counted = [&](int first, int last) {
    return std::any_of(pixels + first, pixels + last + 1, [&](std::uint8_t label) { return counts(label); });
  };
  constexpr int kEight = sizeof(std::uint64_t);
  if (to - from + 1 < kEight) return counted(from, to);
  for (int first = from;; first = std::min(first + kEight, to - kEight + 1)) {  // the last ones overlap
    std::uint64_t eight = 0;
    std::memcpy(&eight, pixels + first, sizeof eight);
    if (eight != 0 && counted(first, first + kEight - 1)) return true;
    if (first == to - kEight + 1) return false;
  }
}

}  // namespace dynfilter
