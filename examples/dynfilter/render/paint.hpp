// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/random.hpp>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <string>

namespace dynfilter::render {

/// White noise in [0, 1], CV_32FC1.
cv::Mat white_noise(cv::Size size, Random& random);

/// Enlarges a repeating picture without creating a seam.
cv::Mat enlarge_repeating(const cv::Mat& small, cv::Size size);

/// Value noise summed over octaves, approximately in [0, 1], repeating without a seam.
/// `cells`: cells of the coarsest octave across the picture, per axis.
/// Each octave doubles them and has `persistence` times the weight.
cv::Mat fractal_noise(cv::Size size, cv::Size cells, int octaves, double persistence, Random& random);

/// Colour ramp from `low` (value 0) to `high` (value 1) over a CV_32FC1 picture.
/// A gain above 1 increases contrast.
cv::Mat ramp(const cv::Mat& values, const cv::Scalar& low, const cv::Scalar& high, double gain = 1);

/// Multiplies the picture by 1 + depth * (noise - 0.5), for folds, dirt or uneven paint.
void shade_by(cv::Mat& bgr, const cv::Mat& noise, double depth);

inline cv::Scalar bgr(int r, int g, int b) {
  return {static_cast<double>(b), static_cast<double>(g), static_cast<double>(r)};
}

std::string scribble(Random& random, int letters);

/// Lines of dark marks that resemble print from a distance.
void print_lines(cv::Mat& bgr, cv::Rect area, int line_px, const cv::Scalar& ink, Random& random);

}  // namespace dynfilter::render
