// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/evidence/mask_lookup.hpp>

#include <cstddef>
#include <cstring>
#include <dynfilter/core/inline.hpp>
#include <opencv2/core.hpp>

namespace dynfilter {

DYNFILTER_INLINE cv::Size image_size(const FrameView& frame) {
  if (!frame.grey.empty()) return frame.grey.size();
  if (!frame.depth.empty()) return frame.depth.size();
  return frame.camera ? cv::Size(frame.camera->width_px, frame.camera->height_px) : cv::Size();
}

DYNFILTER_INLINE MaskLookup::MaskLookup(const cv::Mat& labels, cv::Size image,
                                        const std::vector<int>& wanted) {
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

DYNFILTER_INLINE bool MaskLookup::at(const cv::Point2f& px) const {
  if (!inside(px)) return false;
  return counts(labels_.at<std::uint8_t>(row_of(std::round(px.y)), column_of(std::round(px.x))));
}

DYNFILTER_INLINE bool MaskLookup::near(const cv::Point2f& px, double radius_px) const {
  return any_chord(px, radius_px, [&](int row, int from, int to) { return any(row, from, to); });
}

inline bool MaskLookup::any(int row, int from, int to) const {
  const std::uint8_t* pixels = labels_.ptr<std::uint8_t>(row);
  while (from <= to) {
    if (from + 7 <= to) {
      std::uint64_t eight = 0;
      std::memcpy(&eight, pixels + from, sizeof(eight));
      if (eight == 0) {
        from += 8;
        continue;
      }
    }
    if (counts(pixels[from])) return true;
    ++from;
  }
  return false;
}

}  // namespace dynfilter
