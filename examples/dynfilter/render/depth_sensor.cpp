// SPDX-License-Identifier: MIT
#include "render/depth_sensor.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace dynfilter::render {

cv::Mat gaussian_tile(int size, double blur_px, Random& random) {
  cv::Mat tile(size, size, CV_32FC1);
  for (int y = 0; y < size; ++y) {
    for (int x = 0; x < size; ++x) {
      // A sum of four uniform numbers is close enough to Gaussian.
      const std::uint64_t bits = random.next();
      std::uint64_t sum = 0;
      for (int k = 0; k < 64; k += 16) sum += (bits >> k) & 0xFFFF;
      tile.at<float>(y, x) = static_cast<float>(sum);
    }
  }
  if (blur_px > 0) cv::GaussianBlur(tile, tile, {}, blur_px, blur_px, cv::BORDER_REFLECT);
  cv::Scalar mean, deviation;
  cv::meanStdDev(tile, mean, deviation);
  return (tile - mean[0]) / deviation[0];
}

DepthSensor::DepthSensor(const Camera& camera, const Options& options, std::uint64_t seed)
    : camera_(camera), options_(options) {
  Random random(seed, 0xD0);
  grain_ = gaussian_tile(kTile, 0.7, random);
  blots_ = gaussian_tile(kTile, 3.0, random);
  fray_x_ = gaussian_tile(kTile, 1.2, random);
  fray_y_ = gaussian_tile(kTile, 1.2, random);
}

void DepthSensor::measure(const GeometryImage& scene, const MaterialSet& set, Random& random, cv::Mat& out) {
  out.create(scene.depth_m.size(), CV_16UC1);
  if (options_.perfect) {
    scene.depth_m.convertTo(out, CV_16U, options_.depth_units_per_m);
    if (options_.farthest_perfect_m > 0) out.setTo(0, scene.depth_m > options_.farthest_perfect_m);
    return;
  }
  offset_ = {random.below(kTile), random.below(kTile)};
  seen_.create(scene.depth_m.size(), CV_32FC1);
  for (int y = 0; y < out.rows; ++y) {
    fray_row(scene, y);
    measure_row(scene, set, y, out.ptr<std::uint16_t>(y));
  }
}

inline void DepthSensor::fray_row(const GeometryImage& scene, int y) {
  const auto fray = static_cast<float>(options_.fray_px);
  for (int x = 0; x < seen_.cols; ++x) {
    const int fx = x + cvRound(fray * noise(fray_x_, x, y)), fy = y + cvRound(fray * noise(fray_y_, x, y));
    seen_.at<float>(y, x) = scene.depth_m.at<float>(std::min(std::max(fy, 0), seen_.rows - 1),
                                                    std::min(std::max(fx, 0), seen_.cols - 1));
  }
}

inline void DepthSensor::measure_row(const GeometryImage& scene, const MaterialSet& set, int y,
                                     std::uint16_t* out) {
  const double fb = camera_.fx_px * options_.baseline_m;
  double most_right = -1e9;  // in the projector's image; points left of it are in the shadow
  for (int x = 0; x < seen_.cols; ++x) {
    out[x] = 0;
    const double z = seen_.at<float>(y, x);
    if (z <= 0) continue;
    const double projected = x + fb / z;
    const bool in_shadow = projected < most_right - 1.0;
    most_right = std::max(most_right, projected);
    if (in_shadow || z < options_.min_depth_m || hole(scene, set, x, y, z)) continue;
    const double spread = 0.0012 + 0.0019 * (z - 0.4) * (z - 0.4), step = options_.disparity_step_px;
    // Its variance step^2 / 12 is part of the measured noise.
    const double rounding = z * z / fb * step;
    const double rest =
        std::sqrt(std::max(0.25 * spread * spread, spread * spread - rounding * rounding / 12));
    const double disparity = fb / z + rest * fb / (z * z) * noise(grain_, x, y);
    const double measured = fb / (std::max(1.0, std::round(disparity / step)) * step);
    if (measured > options_.max_depth_m * (1.0 + 0.06 * noise(blots_, x, y))) continue;
    out[x] = cv::saturate_cast<std::uint16_t>(measured * options_.depth_units_per_m);
  }
}

inline bool DepthSensor::hole(const GeometryImage& scene, const MaterialSet& set, int x, int y,
                              double z) const {
  // Uniform in [0, 1].
  const double blot = 0.5 + 0.5 * std::erf(noise(blots_, x, y) / std::sqrt(2.0));
  const double facing = scene.facing.at<float>(y, x);
  if (facing < 0.05 + 0.13 * blot) return true;
  const std::uint16_t material = scene.material.at<std::uint16_t>(y, x);
  return blot < set.materials[material].depth_dropout * std::min(1.6, 0.4 + 0.3 * z);
}

}  // namespace dynfilter::render
