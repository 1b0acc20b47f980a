// SPDX-License-Identifier: MIT
#include "render/colour_sensor.hpp"

#include <cmath>
#include <opencv2/core.hpp>

#include "render/depth_sensor.hpp"

namespace dynfilter::render {

ColourSensor::ColourSensor(const Options& options, std::uint64_t seed) : options_(options), seed_(seed) {
  Random random(seed, 0xC0);
  cv::Mat planes[3];
  for (cv::Mat& plane : planes) plane = gaussian_tile(kTile, 0.4, random) * options.noise;
  cv::merge(planes, 3, grain_);
  grain_.convertTo(grain_, CV_16SC3);
  for (double& phase : phase_) phase = random.uniform(0, 2 * CV_PI);
}

void ColourSensor::expose(cv::Mat& colour, double time_s, Random& random) const {
  const double factor = gain(time_s);
  if (factor != 1) colour.convertTo(colour, -1, factor);
  if (options_.noise <= 0) return;
  const cv::Point offset = random.below(cv::Size(kTile, kTile));
  for (int y = 0; y < colour.rows; ++y) {
    auto* row = colour.ptr<cv::Vec3b>(y);
    const auto* grain = grain_.ptr<cv::Vec3s>((y + offset.y) % kTile);
    for (int x = 0; x < colour.cols; ++x) {
      const cv::Vec3s& g = grain[(x + offset.x) % kTile];
      for (int c = 0; c < 3; ++c) row[x][c] = cv::saturate_cast<uchar>(row[x][c] + g[c]);
    }
  }
}

double ColourSensor::gain(double time_s) const {
  double factor = 1;
  if (options_.exposure_variation)
    factor = 1.0 + 0.14 * std::sin(2 * CV_PI * time_s / 3.7 + phase_[0]) +
             0.08 * std::sin(2 * CV_PI * time_s / 1.3 + phase_[1]);
  return options_.exposure_steps ? factor * step_gain(time_s) : factor;
}

inline double ColourSensor::step_gain(double time_s) const {
  const double at = time_s + phase_[0];
  auto step = static_cast<std::int64_t>(std::floor(at));
  // This step begins later.
  if (at - std::floor(at) < Random(step_seed(step), 1).uniform(0, 0.5)) --step;
  const double level = std::sqrt(Random(step_seed(step), 2).uniform(1.25, 1.5));
  return step % 2 == 0 ? level : 1 / level;
}

}  // namespace dynfilter::render
