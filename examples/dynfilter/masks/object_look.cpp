// SPDX-License-Identifier: MIT
#include "masks/object_look.hpp"

#include <cmath>
#include <cstdint>
#include <opencv2/core.hpp>

namespace dynfilter::masks {
namespace {

/// Levels of each of blue, green and red: coarse, because light changes.
constexpr int kLevels = 6;
/// Weight of what is seen now.
constexpr double kNewLook = 0.1;

int bin_of(const cv::Vec3b& pixel) {
  int bin = 0;
  for (int c = 0; c < 3; ++c) bin = bin * kLevels + pixel[c] * kLevels / 256;
  return bin;
}

}  // namespace

cv::Mat look_of(const cv::Mat& colour, const RunMask& mask) {
  const cv::Rect box = mask.box() & cv::Rect({0, 0}, colour.size());
  if (box.empty()) return {};
  cv::Mat inside = cv::Mat::zeros(colour.size(), CV_8UC1);
  mask.paint(inside);
  cv::Mat look = cv::Mat::zeros(1, kLevels * kLevels * kLevels, CV_32FC1);
  for (int y = box.y; y < box.br().y; ++y)
    for (int x = box.x; x < box.br().x; ++x)
      if (inside.at<std::uint8_t>(y, x) != 0) look.at<float>(bin_of(colour.at<cv::Vec3b>(y, x))) += 1;
  const double sum = cv::sum(look)[0];
  if (sum > 0) look /= sum;
  return look;
}

double look_distance(const cv::Mat& a, const cv::Mat& b) {
  if (a.empty() || b.empty()) return 1;
  double shared = 0;
  for (int i = 0; i < a.cols; ++i) shared += std::sqrt(static_cast<double>(a.at<float>(i) * b.at<float>(i)));
  return std::sqrt(std::max(0.0, 1 - shared));
}

void blend_look(cv::Mat& remembered, const cv::Mat& seen) {
  if (remembered.empty() || seen.empty())
    remembered = seen;
  else
    remembered = (1 - kNewLook) * remembered + kNewLook * seen;
}

}  // namespace dynfilter::masks
