// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <vector>

namespace dynfilter {

/// Dissimilarity of two patches: 1 - NCC, from 0 (equal) to 2 (inverted).
/// 1 if a patch has no texture. Brightness and contrast do not matter.
/// Uses every second row.
/// Sums are integer sums of fixed-point samples, so results are the same on every machine.
class PatchResidual {
 public:
  explicit PatchResidual(int window_px);

  /// Compares the patches centred on two points.
  /// Both images are CV_8UC1 with at least `window_px` readable pixels around them,
  /// as in an ImagePyramid. Both points must be inside the images.
  double operator()(const cv::Mat& image_a, const cv::Point2f& at_a, const cv::Mat& image_b,
                    const cv::Point2f& at_b);

 private:
  /// Bilinear samples in 1/16 grey level.
  void sample(const cv::Mat& image, const cv::Point2f& at, std::vector<std::int16_t>& out) const;

  int window_px_;
  std::vector<std::int16_t> a_, b_;
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/correspondence/detail/patch_residual-inl.hpp>
#endif
