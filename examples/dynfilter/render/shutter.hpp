// SPDX-License-Identifier: MIT
#pragma once

#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>

#include "render/rasteriser.hpp"

namespace dynfilter::render {

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
  static int steps_for(double exposure_s, double readout_s, double motion_px);

  int steps() const { return steps_; }
  /// Middle of a step relative to the timestamp.
  double offset_s(int step) const { return (begin_s(step) + begin_s(step + 1)) / 2; }
  double row_offset_s(int row) const {
    return (static_cast<double>(row) / static_cast<double>(rows_) - 0.5) * readout_s_;
  }

  /// Share of a row's light; sums to 1 over the steps.
  double weight(int step, int row) const;

  RowRange rows(int step) const;

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
  void begin(cv::Size size);

  void add_row(const cv::Mat& colour, int row, double weight);

  void write(cv::Mat& colour) const;

 private:
  cv::Mat sum_;
};

}  // namespace dynfilter::render
