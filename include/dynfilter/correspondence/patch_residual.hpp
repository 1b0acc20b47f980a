// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

namespace dynfilter {

/// Dissimilarity of two patches: 1 - NCC, from 0 (equal) to 2 (inverted).
/// 1 if a patch has no texture. Brightness and contrast do not matter. Uses every second row.
/// Sums are integer sums of fixed-point samples, so results are the same on every machine.
class PatchResidual {
 public:
  /// For square windows of this width [px].
  explicit PatchResidual(int window_px) : window_px_(window_px) {
    const auto width = static_cast<std::size_t>(window_px), samples = (width + 1) / 2 * width;
    a_.resize(samples);
    b_.resize(samples);
  }

  /// Compares the patches centred on two points. Both images are CV_8UC1 with at least `window_px` readable
  /// pixels around them, as in an ImagePyramid. Both points must be inside the images.
  double operator()(const cv::Mat& image_a, const cv::Point2f& at_a, const cv::Mat& image_b,
                    const cv::Point2f& at_b);

 private:
  /// Bilinear samples in 1/16 grey level.
  void sample(const cv::Mat& image, const cv::Point2f& at, std::vector<std::int16_t>& out) const;

  int window_px_;
  std::vector<std::int16_t> a_, b_;
};

inline double PatchResidual::operator()(const cv::Mat& image_a, const cv::Point2f& at_a,
                                        const cv::Mat& image_b, const cv::Point2f& at_b) {
  sample(image_a, at_a, a_);
  sample(image_b, at_b, b_);
  std::int64_t sum_a = 0, sum_b = 0, aa = 0, bb = 0, ab = 0;
  const auto width = static_cast<std::size_t>(window_px_);
  for (std::size_t row = 0; row < a_.size(); row += width) {
    // 63 samples of at most 4080: the squares of a row fit 32 bits.
    std::int32_t row_a = 0, row_b = 0, row_aa = 0, row_bb = 0, row_ab = 0;
    for (std::size_t k = row; k < row + width; ++k) {
      row_a += a_[k];
      row_b += b_[k];
      row_aa += a_[k] * a_[k];
      row_bb += b_[k] * b_[k];
      row_ab += a_[k] * b_[k];
    }
    sum_a += row_a, sum_b += row_b, aa += row_aa, bb += row_bb, ab += row_ab;
  }
  const auto n = static_cast<std::int64_t>(a_.size());
  const auto variances =
      static_cast<double>(n * aa - sum_a * sum_a) * static_cast<double>(n * bb - sum_b * sum_b);
  return variances > 0 ? 1 - static_cast<double>(n * ab - sum_a * sum_b) / std::sqrt(variances) : 1;
}

inline void PatchResidual::sample(const cv::Mat& image, const cv::Point2f& at,
                                  std::vector<std::int16_t>& out) const {
  const float half = static_cast<float>(window_px_ - 1) / 2;
  const float x = at.x - half, y = at.y - half;
  const int left = cvFloor(x), top = cvFloor(y);
  const auto u = static_cast<unsigned>((x - static_cast<float>(left)) * 16);
  const auto v = static_cast<unsigned>((y - static_cast<float>(top)) * 16);
  const auto w00 = static_cast<std::uint16_t>((16 - u) * (16 - v)),
             w01 = static_cast<std::uint16_t>(u * (16 - v)), w10 = static_cast<std::uint16_t>((16 - u) * v),
             w11 = static_cast<std::uint16_t>(u * v);
  const auto step = static_cast<std::ptrdiff_t>(image.step[0]);
  std::int16_t* to = out.data();
  for (int row = 0; row < window_px_; row += 2, to += window_px_) {
    const unsigned char* upper = image.data + (top + row) * step + left;
    const unsigned char* lower = upper + step;
    for (int k = 0; k < window_px_; ++k) {
      const auto sum = static_cast<std::uint16_t>(upper[k] * w00 + upper[k + 1] * w01 + lower[k] * w10 +
                                                  lower[k + 1] * w11);  // at most 255 * 256
      to[k] = static_cast<std::int16_t>(sum >> 4U);
    }
  }
}

}  // namespace dynfilter
