// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/cluster/depth_growth.hpp>

#include <algorithm>
#include <cmath>
#include <dynfilter/core/inline.hpp>
#include <limits>
#include <opencv2/core.hpp>

namespace dynfilter {

DYNFILTER_INLINE void DepthGrowth::grow(const cv::Mat& depth, double unit_m, const Camera& camera,
                                        Span<const cv::Point2f> seeds_px, cv::Mat& mask,
                                        Span<const cv::Point2f> rivals_px) {
  mask.create(depth.size(), CV_8UC1);
  mask.setTo(0);
  if (depth.empty()) return;
  set_rays(camera, depth.size());
  unit_m_ = static_cast<float>(unit_m);
  if (depth.type() == CV_32FC1)
    run<float>(depth, seeds_px, rivals_px, mask);
  else if (depth.type() == CV_16UC1)
    run<std::uint16_t>(depth, seeds_px, rivals_px, mask);
  if (!rivals_px.empty()) mask.setTo(0, mask == kRival);
}

inline void DepthGrowth::set_rays(const Camera& camera, cv::Size size) {
  const bool valid = camera.valid(), limited = valid && params_.max_reach_m > 0;
  const auto reach_m = static_cast<float>(params_.max_reach_m);
  reach2_m2_ = limited ? reach_m * reach_m : std::numeric_limits<float>::infinity();
  const auto fill = [&](int n, double centre, double focal, std::vector<float>& rays) {
    rays.assign(static_cast<std::size_t>(n), 0);
    for (int i = 0; valid && i < n; ++i)
      rays[static_cast<std::size_t>(i)] =
          (static_cast<float>(i) - static_cast<float>(centre)) / static_cast<float>(focal);
  };
  fill(size.width, camera.cx_px, camera.fx_px, ray_x_);
  fill(size.height, camera.cy_px, camera.fy_px, ray_y_);
}

template <class T>
float DepthGrowth::depth_m(const cv::Mat& depth, int x, int y) const {
  return static_cast<float>(depth.at<T>(y, x)) * unit_m_;
}

template <class T>
void DepthGrowth::run(const cv::Mat& depth, Span<const cv::Point2f> seeds_px,
                      Span<const cv::Point2f> rivals_px, cv::Mat& mask) {
  // Each pixel is opened once; up to four writes may be discarded.
  open_.resize(depth.total() + 4);
  end_ = 0;
  seeds_.clear();
  add_seeds<T>(depth, seeds_px, kGrown, mask);
  add_seeds<T>(depth, rivals_px, kRival, mask);
  // First in, first out: a pixel belongs to approximately the nearest seed.
  for (std::size_t next = 0; next < end_; ++next) spread<T>(depth, open_[next], mask);
}

template <class T>
void DepthGrowth::add_seeds(const cv::Mat& depth, Span<const cv::Point2f> seeds_px, std::uint8_t label,
                            cv::Mat& mask) {
  for (const cv::Point2f& seed : seeds_px) {
    if (!(seed.x > -0.5F && seed.y > -0.5F && seed.x < 32767 && seed.y < 32767)) continue;
    const int x = cvRound(seed.x), y = cvRound(seed.y);
    if (x >= depth.cols || y >= depth.rows || mask.at<std::uint8_t>(y, x) != 0) continue;
    const float z = depth_m<T>(depth, x, y);
    if (!(z > 0 && std::isfinite(z))) continue;
    mask.at<std::uint8_t>(y, x) = label;
    open_[end_++] = {x, y, static_cast<std::uint32_t>(seeds_.size())};
    seeds_.push_back({point_m(x, y, z), label});
  }
}

template <class T>
void DepthGrowth::spread(const cv::Mat& depth, const Pixel from, cv::Mat& mask) {
  using Four = float __attribute__((vector_size(16)));
  // Beyond the border, the pixel itself is used, which is already taken.
  const int xs[4] = {std::min(from.x + 1, depth.cols - 1), std::max(from.x - 1, 0), from.x, from.x};
  const int ys[4] = {from.y, from.y, std::min(from.y + 1, depth.rows - 1), std::max(from.y - 1, 0)};
  const Seed seed = seeds_[from.seed];
  const float z = depth_m<T>(depth, from.x, from.y);
  const float max_step_m = static_cast<float>(params_.max_step_share) * z;
  Four there, ray_x, ray_y;
  for (int k = 0; k < 4; ++k) {
    there[k] = depth_m<T>(depth, xs[k], ys[k]);
    ray_x[k] = ray_x_[static_cast<std::size_t>(xs[k])];
    ray_y[k] = ray_y_[static_cast<std::size_t>(ys[k])];
  }
  const Four step = there - z, away_x = ray_x * there - seed.at_m.x, away_y = ray_y * there - seed.at_m.y,
             away_z = there - seed.at_m.z;
  const auto reached = (there > 0) & (step <= max_step_m) & (step >= -max_step_m) &
                       (away_x * away_x + away_y * away_y + away_z * away_z <= reach2_m2_);
  std::size_t end = end_;
  for (int k = 0; k < 4; ++k) {
    std::uint8_t& label = mask.at<std::uint8_t>(ys[k], xs[k]);
    const unsigned taken = static_cast<unsigned>(reached[k]) & (0U - static_cast<unsigned>(label == 0));
    label = static_cast<std::uint8_t>(label | (seed.label & taken));
    open_[end] = {xs[k], ys[k], from.seed};
    end += taken & 1U;
  }
  end_ = end;
}

}  // namespace dynfilter
