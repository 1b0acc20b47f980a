// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <dynfilter/synth/rasteriser.hpp>
#include <opencv2/core.hpp>

namespace dynfilter::synth {

/// Exposure of the rows of an image relative to its timestamp, and the instants rendered for it.
/// Row y collects light for `exposure_s` around (y / rows - 0.5) * readout_s.
/// The total time is divided into equal steps. Each is rendered at its middle.
/// Its weight in a row is its share of the row's exposure.
class Shutter {
 public:
  Shutter(double exposure_s, double readout_s, int steps, int rows)
      : exposure_s_(exposure_s), readout_s_(readout_s), steps_(steps), rows_(rows) {}

  /// Number of steps if the fastest point moves by `motion_px` during exposure and readout.
  /// Blur alone: one per 1.5 px, at most 24.
  /// Rolling rows: the edge between two bands is at most 0.3 px, with at most 128 steps.
  static int steps_for(double exposure_s, double readout_s, double motion_px) {
    const double span_s = exposure_s + readout_s;
    if (span_s <= 0) return 1;
    const double blur_px = motion_px * exposure_s / span_s;
    const double step_px =
        readout_s > 0 ? std::min(kBlurStep_px, std::max(kBandStep_px, blur_px / 2)) : kBlurStep_px;
    const int most = readout_s > 0 ? kMostBands : kMostSubFrames;
    return static_cast<int>(std::min<double>(most, std::max(1.0, std::ceil(motion_px / step_px))));
  }

  int steps() const { return steps_; }
  /// Middle of a step relative to the timestamp.
  double offset_s(int step) const { return (begin_s(step) + begin_s(step + 1)) / 2; }
  double row_offset_s(int row) const {
    return (static_cast<double>(row) / static_cast<double>(rows_) - 0.5) * readout_s_;
  }

  /// Share of a row's light; sums to 1 over the steps.
  double weight(int step, int row) const {
    if (steps_ == 1) return 1;
    const double low = begin_s(step), high = begin_s(step + 1), row_s = row_offset_s(row);
    if (exposure_s_ <= 0) return row_s >= low && row_s < high ? 1 : 0;
    const double overlap = std::min(high, row_s + exposure_s_ / 2) - std::max(low, row_s - exposure_s_ / 2);
    return std::max(0.0, overlap / exposure_s_);
  }

  RowRange rows(int step) const {
    RowRange range{rows_, -1};
    for (int row = 0; row < rows_; ++row) {
      if (weight(step, row) <= 0) continue;
      range.first = std::min(range.first, row);
      range.last = row;
    }
    return range;
  }

 private:
  static constexpr double kBlurStep_px = 1.5, kBandStep_px = 0.3;
  static constexpr int kMostSubFrames = 24, kMostBands = 128;

  double span_s() const { return exposure_s_ + readout_s_; }
  double begin_s(int step) const { return span_s() * (static_cast<double>(step) / steps_ - 0.5); }

  double exposure_s_, readout_s_;
  int steps_, rows_;
};

/// Sums light. Grey levels are its square root, a display gamma of 2.
class LightSum {
 public:
  void begin(cv::Size size) {
    sum_.create(size, CV_32FC3);
    sum_.setTo(0);
  }

  void add_row(const cv::Mat& colour, int row, double weight) {
    const auto w = static_cast<float>(weight);
    const auto* in = colour.ptr<cv::Vec3b>(row);
    auto* out = sum_.ptr<cv::Vec3f>(row);
    for (int x = 0; x < sum_.cols; ++x) {
      for (int c = 0; c < 3; ++c) {
        const auto grey = static_cast<float>(in[x][c]);
        out[x][c] += w * grey * grey;
      }
    }
  }

  void write(cv::Mat& colour) const {
    colour.create(sum_.size(), CV_8UC3);
    for (int y = 0; y < sum_.rows; ++y) {
      const auto* in = sum_.ptr<cv::Vec3f>(y);
      auto* out = colour.ptr<cv::Vec3b>(y);
      for (int x = 0; x < sum_.cols; ++x) {
        for (int c = 0; c < 3; ++c) out[x][c] = cv::saturate_cast<uchar>(std::sqrt(in[x][c]));
      }
    }
  }

 private:
  cv::Mat sum_;
};

}  // namespace dynfilter::synth
