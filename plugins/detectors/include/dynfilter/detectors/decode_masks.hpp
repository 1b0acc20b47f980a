// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/detectors/input_fit.hpp>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <vector>

namespace dynfilter {

/// Converts a score map per class, 1 x classes x H x W, to the label image of the largest class.
/// The result is CV_8UC1, H x W.
/// A single class is a foreground map: label 1 where it is above `min_foreground`.
/// `foreground_bias` is added to all classes except the first, the background.
/// Throws Error if the output has another layout.
void decode_class_scores(const cv::Mat& output, int classes, float min_foreground, float foreground_bias,
                         cv::Mat& labels);

/// The part of a label image of a network's input that contains the image, not resized.
cv::Mat image_part(const cv::Mat& labels, const InputFit& fit);

/// Instance masks of YOLOv5 and YOLOv8.
/// `prototypes` is 1 x K x h x w and covers the whole input of the network.
/// The mask of a box is the sum of the prototypes times the coefficients of the box.
/// Inside means above 0, a sigmoid above 0.5, within the box.
class PrototypeMasks {
 public:
  /// Throws Error if the tensor has another layout.
  explicit PrototypeMasks(const cv::Mat& prototypes);
  int coefficients() const { return prototypes_.size[1]; }  ///< length K of a box's coefficients

  /// CV_8UC1 of the image's size, 255 inside. `box` is in pixels of the image.
  /// Interpolates bilinearly between prototype pixels.
  cv::Mat mask(const std::vector<float>& coefficients, const cv::Rect2f& box, const InputFit& fit);

 private:
  void combine(const std::vector<float>& coefficients);
  float bilinear(float u, float v) const;

  cv::Mat prototypes_, sum_;
};

/// Mask coefficients of a box: the last `coefficients` values of its row in YOLOv5, or of its column in
/// YOLOv8.
std::vector<float> mask_coefficients(const cv::Mat& output, int anchor, int coefficients, bool in_columns);

}  // namespace dynfilter
