// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <dynfilter/core/cells.hpp>
#include <dynfilter/evidence/evidence.hpp>
#include <opencv2/core.hpp>

namespace dynfilter::detail {

/// The image that flow is measured in: positions from the principal point, with square pixels.
class FlowView {
 public:
  void reset() { extent_ = {}; }
  /// Without a camera a focal length is assumed, without an image the extent of the features so far.
  void look(const Evidence& evidence) {
    for (const cv::Point2f& px : evidence.pixels()) {
      if (!within(px)) continue;
      extent_.width = std::max(extent_.width, static_cast<double>(px.x));
      extent_.height = std::max(extent_.height, static_cast<double>(px.y));
    }
    const FrameView& frame = evidence.frame();
    cv::Size2d size = extent_;
    if (!frame.grey.empty())
      size = {static_cast<double>(frame.grey.cols), static_cast<double>(frame.grey.rows)};
    else if (frame.camera && frame.camera->width_px > 0 && frame.camera->height_px > 0)
      size = {static_cast<double>(frame.camera->width_px), static_cast<double>(frame.camera->height_px)};
    cells_.width_px = std::max(1.0, size.width);
    cells_.height_px = std::max(1.0, size.height);
    centre_ = {size.width / 2, size.height / 2};
    focal_px_ = kFocalOfWidth * cells_.width_px;
    y_scale_ = 1;
    if (!frame.camera || !frame.camera->valid()) return;
    centre_ = {frame.camera->cx_px, frame.camera->cy_px};
    focal_px_ = frame.camera->fx_px;
    y_scale_ = frame.camera->fx_px / frame.camera->fy_px;
  }
  /// False for NaN and for positions outside any image.
  static bool within(const cv::Point2f& px) { return std::abs(px.x) < 1e5F && std::abs(px.y) < 1e5F; }
  cv::Point2d centred(const cv::Point2f& px) const {
    return {static_cast<double>(px.x) - centre_.x, (static_cast<double>(px.y) - centre_.y) * y_scale_};
  }
  double focal_px() const { return focal_px_; }
  double width_px() const { return cells_.width_px; }
  double height_px() const { return cells_.height_px; }
  const ImageCells<double>& cells() const { return cells_; }  ///< each with one vote

 private:
  static constexpr double kFocalOfWidth = 0.8;  ///< focal length in image widths if no camera is given
  static constexpr int kColumns = 12, kRows = 6;

  cv::Size2d extent_;
  ImageCells<double> cells_{0, 0, kColumns, kRows, 0.5};
  cv::Point2d centre_;
  double focal_px_ = 1, y_scale_ = 1;
};

}  // namespace dynfilter::detail
