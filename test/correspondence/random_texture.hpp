// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstddef>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <random>
#include <vector>

namespace test {

/// A sum of random waves. Its closed form makes shifts by fractions of a pixel exact.
class WaveTexture {
 public:
  explicit WaveTexture(unsigned seed, int waves = 60) {
    std::mt19937 random(seed);
    const auto unit = [&] { return static_cast<double>(random()) / 4294967296.0; };
    for (int w = 0; w < waves; ++w) {
      const double length_px = 6 + 50 * unit(), direction = 6.283185307 * unit();
      waves_.push_back({6.283185307 / length_px * std::cos(direction),
                        6.283185307 / length_px * std::sin(direction), 6.283185307 * unit()});
    }
  }
  /// As many waves in each octave of lengths up to 600 px, like in views of a room. No pixel is saturated.
  static WaveTexture broad(unsigned seed, int waves = 60) {
    WaveTexture texture(seed, 0);
    texture.contrast_ = 35;
    std::mt19937 random(seed);
    const auto unit = [&] { return static_cast<double>(random()) / 4294967296.0; };
    for (int w = 0; w < waves; ++w) {
      const double length_px = 6 * std::pow(100, unit()), direction = 6.283185307 * unit();
      texture.waves_.push_back({6.283185307 / length_px * std::cos(direction),
                                6.283185307 / length_px * std::sin(direction), 6.283185307 * unit()});
    }
    return texture;
  }
  double operator()(double x, double y) const {
    double sum = 0;
    for (const Wave& w : waves_) sum += std::cos(w.kx * x + w.ky * y + w.phase);
    return grey_of(sum);
  }
  /// Pixel (x, y) shows the texture at (x + shift.x, y + shift.y).
  cv::Mat image(cv::Size size, cv::Point2d shift = {}) const {
    // cos(a + b) of columns and rows: a cosine per pixel and wave would take most of the tests' time.
    const auto width = static_cast<std::size_t>(size.width);
    std::vector<double> cosines, sines, sum(width);
    for (const Wave& w : waves_)
      for (int x = 0; x < size.width; ++x) {
        cosines.push_back(std::cos(w.kx * (x + shift.x)));
        sines.push_back(std::sin(w.kx * (x + shift.x)));
      }
    cv::Mat grey(size, CV_8UC1);
    for (int y = 0; y < size.height; ++y) {
      sum.assign(width, 0);
      for (std::size_t k = 0; k < waves_.size(); ++k) {
        const double angle = waves_[k].ky * (y + shift.y) + waves_[k].phase;
        const double c = std::cos(angle), s = std::sin(angle);
        const double *column_c = &cosines[k * width], *column_s = &sines[k * width];
        for (std::size_t x = 0; x < width; ++x) sum[x] += c * column_c[x] - s * column_s[x];
      }
      for (std::size_t x = 0; x < width; ++x)
        grey.at<unsigned char>(y, static_cast<int>(x)) = cv::saturate_cast<unsigned char>(grey_of(sum[x]));
    }
    return grey;
  }

 private:
  struct Wave {
    double kx, ky, phase;
  };
  double grey_of(double sum) const {
    return 128 + contrast_ * sum / std::sqrt(static_cast<double>(waves_.size()));
  }

  std::vector<Wave> waves_;
  double contrast_ = 90;
};

inline cv::Mat noise_image(cv::Size size, unsigned seed, double sigma_px) {
  std::mt19937 random(seed);
  cv::Mat grey(size, CV_8UC1);
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x)
      grey.at<unsigned char>(y, x) = static_cast<unsigned char>(random() >> 24U);
  if (sigma_px > 0) {
    cv::GaussianBlur(grey, grey, {}, sigma_px);
    cv::normalize(grey, grey, 0, 255, cv::NORM_MINMAX);
  }
  return grey;
}

inline std::vector<cv::Point2f> random_points(cv::Size size, std::size_t n, float margin_px, unsigned seed) {
  std::mt19937 random(seed);
  const auto unit = [&] { return static_cast<float>(random() >> 8U) / 16777216.0F; };
  std::vector<cv::Point2f> points;
  for (std::size_t i = 0; i < n; ++i)
    points.emplace_back(margin_px + unit() * (static_cast<float>(size.width) - 1 - 2 * margin_px),
                        margin_px + unit() * (static_cast<float>(size.height) - 1 - 2 * margin_px));
  return points;
}

}  // namespace test
