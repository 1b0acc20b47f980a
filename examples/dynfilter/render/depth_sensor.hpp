// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/random.hpp>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>

#include "render/rasteriser.hpp"
#include "render/texture.hpp"

namespace dynfilter::render {

/// Nearly Gaussian noise of unit variance, CV_32FC1.
/// Slightly smoothed, because a structured-light camera correlates windows.
cv::Mat gaussian_tile(int size, double blur_px, Random& random);

/// Simulates a Kinect's measurement of a depth image.
/// Axial noise: sigma = 0.0012 + 0.0019 (z - 0.4)^2 m (Nguyen, Izadi, Lovell, "Modeling Kinect sensor noise",
/// 3DIMPVT 2012).
/// Disparity steps of 1/8 px and the projector's shadow follow from its baseline of 75 mm.
/// Silhouettes are uneven by one or two pixels.
/// Dark, shiny and grazing surfaces have holes.
class DepthSensor {
 public:
  struct Options {
    double baseline_m = 0.075, disparity_step_px = 0.125, fray_px = 1.1;
    double min_depth_m = 0.45, max_depth_m = 8.0, depth_units_per_m = 5000;
    bool perfect = false;           ///< true depth, no holes
    double farthest_perfect_m = 0;  ///< true depth up to here; 0: as far as the units reach
  };

  DepthSensor(const Camera& camera, const Options& options, std::uint64_t seed);

  /// CV_16UC1, 0: no depth.
  void measure(const GeometryImage& scene, const MaterialSet& set, Random& random, cv::Mat& out);

 private:
  static constexpr int kTile = 512;

  float noise(const cv::Mat& tile, int x, int y) const {
    return tile.at<float>((y + offset_.y) % kTile, (x + offset_.x) % kTile);
  }

  /// The window that determines a pixel's depth is not exactly centred on it.
  void fray_row(const GeometryImage& scene, int y);

  void measure_row(const GeometryImage& scene, const MaterialSet& set, int y, std::uint16_t* out);

  bool hole(const GeometryImage& scene, const MaterialSet& set, int x, int y, double z) const;

  Camera camera_;
  Options options_;
  cv::Mat grain_, blots_, fray_x_, fray_y_, seen_;
  cv::Point offset_;
};

}  // namespace dynfilter::render
