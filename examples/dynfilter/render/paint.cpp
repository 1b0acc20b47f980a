// SPDX-License-Identifier: MIT
#include "render/paint.hpp"

#include <algorithm>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace dynfilter::render {

cv::Mat white_noise(cv::Size size, Random& random) {
  cv::Mat noise(size, CV_32FC1);
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) noise.at<float>(y, x) = static_cast<float>(random.uniform());
  }
  return noise;
}

cv::Mat enlarge_repeating(const cv::Mat& small, cv::Size size) {
  if (small.size() == size) return small;
  constexpr int kMargin = 2;
  const double sx = static_cast<double>(size.width) / small.cols,
               sy = static_cast<double>(size.height) / small.rows;
  cv::Mat padded, large;
  cv::copyMakeBorder(small, padded, kMargin, kMargin, kMargin, kMargin, cv::BORDER_WRAP);
  cv::resize(padded, large, {cvRound(padded.cols * sx), cvRound(padded.rows * sy)}, 0, 0, cv::INTER_CUBIC);
  return large(cv::Rect(cvRound(kMargin * sx), cvRound(kMargin * sy), size.width, size.height)).clone();
}

cv::Mat fractal_noise(cv::Size size, cv::Size cells, int octaves, double persistence, Random& random) {
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

cv::Mat ramp(const cv::Mat& values, const cv::Scalar& low, const cv::Scalar& high, double gain) {
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

void shade_by(cv::Mat& bgr, const cv::Mat& noise, double depth) {
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

std::string scribble(Random& random, int letters) {
  static constexpr char kLetters[] = "ABCDEFGHKLMNOPRSTUVWXYZaeioursnt";
  std::string text;
  for (int i = 0; i < letters; ++i) text += kLetters[random.below(static_cast<int>(sizeof(kLetters)) - 1)];
  return text;
}

void print_lines(cv::Mat& bgr, cv::Rect area, int line_px, const cv::Scalar& ink, Random& random) {
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

}  // namespace dynfilter::render
