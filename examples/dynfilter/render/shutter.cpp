// SPDX-License-Identifier: MIT
#include "render/shutter.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>

namespace dynfilter::render {

int Shutter::steps_for(double exposure_s, double readout_s, double motion_px) {
  const double span_s = exposure_s + readout_s;
  if (span_s <= 0) return 1;
  const double blur_px = motion_px * exposure_s / span_s;
  const double step_px =
      readout_s > 0 ? std::min(kBlurStep_px, std::max(kBandStep_px, blur_px / 2)) : kBlurStep_px;
  const int most = readout_s > 0 ? kMostBands : kMostSubFrames;
  return static_cast<int>(std::min<double>(most, std::max(1.0, std::ceil(motion_px / step_px))));
}

double Shutter::weight(int step, int row) const {
  if (steps_ == 1) return 1;
  const double low = begin_s(step), high = begin_s(step + 1), row_s = row_offset_s(row);
  if (exposure_s_ <= 0) return row_s >= low && row_s < high ? 1 : 0;
  const double overlap = std::min(high, row_s + exposure_s_ / 2) - std::max(low, row_s - exposure_s_ / 2);
  return std::max(0.0, overlap / exposure_s_);
}

RowRange Shutter::rows(int step) const {
  RowRange range{rows_, -1};
  for (int row = 0; row < rows_; ++row) {
    if (weight(step, row) <= 0) continue;
    range.first = std::min(range.first, row);
    range.last = row;
  }
  return range;
}

void LightSum::begin(cv::Size size) {
  sum_.create(size, CV_32FC3);
  sum_.setTo(0);
}

void LightSum::add_row(const cv::Mat& colour, int row, double weight) {
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

void LightSum::write(cv::Mat& colour) const {
  colour.create(sum_.size(), CV_8UC3);
  for (int y = 0; y < sum_.rows; ++y) {
    const auto* in = sum_.ptr<cv::Vec3f>(y);
    auto* out = colour.ptr<cv::Vec3b>(y);
    for (int x = 0; x < sum_.cols; ++x) {
      for (int c = 0; c < 3; ++c) out[x][c] = cv::saturate_cast<uchar>(std::sqrt(in[x][c]));
    }
  }
}

}  // namespace dynfilter::render
