// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/random.hpp>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <vector>

#include "render/furniture.hpp"

namespace dynfilter::render {

/// Errors of a detector.
struct DetectorFaults {
  double missed_share = 0.05;  ///< share of the objects, independent per image
  double box_jitter = 0.012;   ///< standard deviation of each side, as a share of the box
  double score_noise = 0.06;
  /// Share of the images with two overlapping people that have one box for both.
  double merged_share = 0.5;
  double merge_above_iou = 0.15;
  int late_frames = 0;    ///< the result with frame i is of frame i - late_frames
  int smallest_px = 150;  ///< smallest visible area that is detected
};

/// Bounding boxes of the visible part of every object.
/// Entry i is instance i + 1, empty if it is not visible.
std::vector<cv::Rect> visible_boxes(const cv::Mat& instance, std::size_t objects, int smallest_px);

float intersection_over_union(const cv::Rect2f& a, const cv::Rect2f& b);

/// Simulates the output of a detector for an image.
class DetectorModel {
 public:
  explicit DetectorModel(const DetectorFaults& faults) : faults_(faults) {}

  std::vector<Detection> detect(const cv::Mat& instance, const std::vector<Detectable>& objects,
                                Random& random) const;

 private:
  void merge_people(std::vector<Detection>& found, Random& random) const;

  void disturb(Detection& d, cv::Size picture, Random& random) const;

  DetectorFaults faults_;
};

}  // namespace dynfilter::render
