// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/synth/random.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <string>

namespace dynfilter::synth {

/// White noise in [0, 1], CV_32FC1.
inline cv::Mat white_noise(cv::Size size, Random& random) {
  cv::Mat noise(size, CV_32FC1);
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) noise.at<float>(y, x) = static_cast<float>(random.uniform());
  }
  return noise;
}

/// Enlarges a repeating picture without creating a seam.
inline cv::Mat enlarge_repeating(const cv::Mat& small, cv::Size size) {
  if (small.size() == size) return small;
  constexpr int kMargin = 2;
  const double sx = static_cast<double>(size.width) / small.cols,
               sy = static_cast<double>(size.height) / small.rows;
  cv::Mat padded, large;
  cv::copyMakeBorder(small, padded, kMargin, kMargin, kMargin, kMargin, cv::BORDER_WRAP);
  cv::resize(padded, large, {cvRound(padded.cols * sx), cvRound(padded.rows * sy)}, 0, 0, cv::INTER_CUBIC);
  return large(cv::Rect(cvRound(kMargin * sx), cvRound(kMargin * sy), size.width, size.height)).clone();
}

/// Value noise summed over octaves, approximately in [0, 1], repeating without a seam.
/// `cells`: cells of the coarsest octave across the picture, per axis.
/// Each octave doubles them and has `persistence` times the weight.
inline cv::Mat fractal_noise(cv::Size size, cv::Size cells, int octaves, double persistence, Random& random) {
  cv::Mat sum;
  double weight = 1, total = 0;
  for (int o = 0; o < octaves; ++o, weight *= persistence) {
    const cv::Size grid(std::min(size.width, cells.width << o), std::min(size.height, cells.height << o));
    const cv::Mat fresh = white_noise(grid, random) * weight;
    sum = o == 0 ? fresh : cv::Mat(enlarge_repeating(sum, grid) + fresh);
    total += weight;
  }
  return enlarge_repeating(sum, size) / total;
}

/// Colour ramp from `low` (value 0) to `high` (value 1) over a CV_32FC1 picture.
/// A gain above 1 increases contrast.
inline cv::Mat ramp(const cv::Mat& values, const cv::Scalar& low, const cv::Scalar& high, double gain = 1) {
  cv::Mat out(values.size(), CV_8UC3);
  for (int y = 0; y < out.rows; ++y) {
    for (int x = 0; x < out.cols; ++x) {
      const double t = std::min(1.0, std::max(0.0, 0.5 + gain * (values.at<float>(y, x) - 0.5)));
      for (int c = 0; c < 3; ++c) {
        out.at<cv::Vec3b>(y, x)[c] = cv::saturate_cast<uchar>(low[c] + t * (high[c] - low[c]));
      }
    }
  }
  return out;
}

/// Multiplies the picture by 1 + depth * (noise - 0.5), for folds, dirt or uneven paint.
inline void shade_by(cv::Mat& bgr, const cv::Mat& noise, double depth) {
  for (int y = 0; y < bgr.rows; ++y) {
    for (int x = 0; x < bgr.cols; ++x) {
      const double k = 1.0 + depth * (noise.at<float>(y, x) - 0.5);
      for (int c = 0; c < 3; ++c) {
        uchar& value = bgr.at<cv::Vec3b>(y, x)[c];
        value = cv::saturate_cast<uchar>(value * k);
      }
    }
  }
}

inline cv::Scalar bgr(int r, int g, int b) {
  return {static_cast<double>(b), static_cast<double>(g), static_cast<double>(r)};
}

inline std::string scribble(Random& random, int letters) {
  static constexpr char kLetters[] = "ABCDEFGHKLMNOPRSTUVWXYZaeioursnt";
  std::string text;
  for (int i = 0; i < letters; ++i) text += kLetters[random.below(static_cast<int>(sizeof(kLetters)) - 1)];
  return text;
}

/// Lines of dark marks that resemble print from a distance.
inline void print_lines(cv::Mat& bgr, cv::Rect area, int line_px, const cv::Scalar& ink, Random& random) {
  for (int y = area.y; y + line_px / 2 < area.y + area.height; y += line_px) {
    int x = area.x;
    const int end = area.x + static_cast<int>(area.width * random.uniform(0.6, 1.0));
    while (x < end) {
      const int word = 2 + random.below(std::max(2, line_px * 2));
      cv::rectangle(bgr, cv::Rect(x, y, std::min(word, end - x), std::max(1, line_px / 2)), ink, cv::FILLED);
      x += word + std::max(1, line_px / 3);
    }
  }
}

}  // namespace dynfilter::synth
