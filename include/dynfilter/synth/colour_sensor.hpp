// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <dynfilter/synth/depth_sensor.hpp>
#include <opencv2/core.hpp>

namespace dynfilter::synth {

/// Noise, exposure and motion blur of a colour camera.
class ColourSensor {
 public:
  struct Options {
    double noise = 1.6;  ///< standard deviation in grey levels; 0: none
    bool exposure_variation = false;
    bool motion_blur = false;
    double shutter_share = 0.4;  ///< of the time between two frames
  };

  ColourSensor(const Options& options, std::uint64_t seed) : options_(options) {
    Random random(seed, 0xC0);
    cv::Mat planes[3];
    for (cv::Mat& plane : planes) plane = gaussian_tile(kTile, 0.4, random) * options.noise;
    cv::merge(planes, 3, grain_);
    grain_.convertTo(grain_, CV_16SC3);
    for (double& phase : phase_) phase = random.uniform(0, 2 * CV_PI);
  }

  /// `flow_px`: CV_32FC2, motion of every pixel since the last frame; used for motion blur only.
  void expose(cv::Mat& colour, const cv::Mat& flow_px, double time_s, Random& random) {
    if (options_.motion_blur) blur(colour, flow_px);
    if (options_.exposure_variation) colour.convertTo(colour, -1, gain(time_s));
    if (options_.noise <= 0) return;
    const cv::Point offset(random.below(kTile), random.below(kTile));
    for (int y = 0; y < colour.rows; ++y) {
      auto* row = colour.ptr<cv::Vec3b>(y);
      const auto* grain = grain_.ptr<cv::Vec3s>((y + offset.y) % kTile);
      for (int x = 0; x < colour.cols; ++x) {
        const cv::Vec3s& g = grain[(x + offset.x) % kTile];
        for (int c = 0; c < 3; ++c) row[x][c] = cv::saturate_cast<uchar>(row[x][c] + g[c]);
      }
    }
  }

  double gain(double time_s) const {
    return 1.0 + 0.14 * std::sin(2 * CV_PI * time_s / 3.7 + phase_[0]) +
           0.08 * std::sin(2 * CV_PI * time_s / 1.3 + phase_[1]);
  }

 private:
  static constexpr int kTile = 512;

  void blur(cv::Mat& colour, const cv::Mat& flow_px) {
    colour.copyTo(sharp_);
    const auto shutter = static_cast<float>(options_.shutter_share);
    for (int y = 0; y < colour.rows; ++y) {
      for (int x = 0; x < colour.cols; ++x) {
        const cv::Vec2f way = flow_px.at<cv::Vec2f>(y, x) * shutter;
        const int taps = std::min(13, 1 + 2 * static_cast<int>(std::lround(cv::norm(way) / 2)));
        if (taps == 1) continue;
        cv::Vec3i sum(0, 0, 0);
        for (int i = 0; i < taps; ++i) {
          const float t = static_cast<float>(i) / static_cast<float>(taps - 1) - 0.5F;
          const int sx = std::min(colour.cols - 1, std::max(0, cvRound(static_cast<float>(x) + t * way[0])));
          const int sy = std::min(colour.rows - 1, std::max(0, cvRound(static_cast<float>(y) + t * way[1])));
          sum += cv::Vec3i(sharp_.at<cv::Vec3b>(sy, sx));
        }
        for (int c = 0; c < 3; ++c)
          colour.at<cv::Vec3b>(y, x)[c] = static_cast<uchar>((sum[c] + taps / 2) / taps);
      }
    }
  }

  Options options_;
  cv::Mat grain_, sharp_;
  double phase_[2];
};

}  // namespace dynfilter::synth
