// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <dynfilter/core/random.hpp>
#include <opencv2/core/mat.hpp>

namespace dynfilter::render {

/// Noise and exposure of a colour camera.
class ColourSensor {
 public:
  struct Options {
    double noise = 1.6;               ///< standard deviation in grey levels; 0: no noise
    bool exposure_variation = false;  ///< smooth variation
    bool exposure_steps = false;      ///< jumps about once per second
  };

  ColourSensor(const Options& options, std::uint64_t seed);

  void expose(cv::Mat& colour, double time_s, Random& random) const;

  double gain(double time_s) const;

 private:
  static constexpr int kTile = 512;

  /// Alternately brighter and darker. Consecutive levels differ by a factor of 1.25 to 1.5.
  double step_gain(double time_s) const;
  std::uint64_t step_seed(std::int64_t step) const {
    return seed_ * 1000003ULL + static_cast<std::uint64_t>(step);
  }

  Options options_;
  std::uint64_t seed_;
  cv::Mat grain_;
  double phase_[2];
};

}  // namespace dynfilter::render
