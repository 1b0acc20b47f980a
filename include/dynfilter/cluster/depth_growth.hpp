// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/simd.hpp>
#include <dynfilter/core/span.hpp>
#include <limits>
#include <opencv2/core.hpp>
#include <vector>

namespace dynfilter {

struct DepthGrowthParams {
  /// Relative depth step between neighbouring pixels that counts as a jump.
  double max_step_share = 0.015;
  /// 3-D distance from the seed that a pixel was grown from; 0: no limit.
  double max_reach_m = 0.5;
};

/// Grows seeds over a depth image and stops at depth jumps. It extends the features of a moving object to its
/// pixels. Zhou et al. (section 3.2.2) use this for maps, DynaSLAM without a limit on the reach for masks.
/// Growth also covers surfaces that touch the object without a jump, such as the floor under feet.
/// max_reach_m limits this. Cost: linear in the grown pixels, plus clearing the mask. Nothing is allocated
/// after the first image of a size.
class DepthGrowth {
 public:
  explicit DepthGrowth(const DepthGrowthParams& params = DepthGrowthParams()) : params_(params) {}

  /// Largest distance that one growth reaches [m].
  void set_max_reach_m(double reach_m) { params_.max_reach_m = reach_m; }

  /// `depth`: CV_32FC1 or CV_16UC1 in units of `unit_m`; any other type grows nothing. `seeds_px`: pixels of
  /// `depth`. Seeds outside the image or without depth are skipped. `mask` becomes CV_8UC1 of the same size,
  /// 255 where grown. `rivals_px`: seeds of the surroundings, such as static features. All seeds grow at the
  /// same rate, and the first one to reach a pixel owns it. The floor under feet is therefore left to the
  /// seeds on the floor. Without a valid camera, the reach has no limit. Distortion is neglected.
  void grow(const cv::Mat& depth, double unit_m, const Camera& camera, Span<const cv::Point2f> seeds_px,
            cv::Mat& mask, Span<const cv::Point2f> rivals_px = {});

 private:
  static constexpr std::uint8_t kGrown = 255, kRival = 1;
  struct Seed {
    cv::Point3f at_m;
    std::uint8_t label;
  };
  struct Pixel {
    int x, y;
    std::uint32_t seed;
  };

  /// Without a valid camera the rays are 0, so the reach has no limit.
  void set_rays(const Camera& camera, cv::Size size);
  cv::Point3f point_m(int x, int y, float z) const {
    return {ray_x_[static_cast<std::size_t>(x)] * z, ray_y_[static_cast<std::size_t>(y)] * z, z};
  }
  template <class T>
  float depth_m(const cv::Mat& depth, int x, int y) const;

  template <class T>
  void run(const cv::Mat& depth, Span<const cv::Point2f> seeds_px, Span<const cv::Point2f> rivals_px,
           cv::Mat& mask);
  template <class T>
  void add_seeds(const cv::Mat& depth, Span<const cv::Point2f> seeds_px, std::uint8_t label, cv::Mat& mask);

  /// Tests four neighbours at a time without branches, because the outcomes are unpredictable.
  template <class T>
  void spread(const cv::Mat& depth, const Pixel from, cv::Mat& mask);

  DepthGrowthParams params_;
  float reach2_m2_ = 0;
  float unit_m_ = 1;
  std::vector<float> ray_x_, ray_y_;  ///< (x - cx) / fx and (y - cy) / fy
  std::vector<Seed> seeds_;
  std::vector<Pixel> open_;
  std::size_t end_ = 0;  ///< number of open pixels
};

inline void DepthGrowth::grow(const cv::Mat& depth, double unit_m, const Camera& camera,
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
  using Four = detail::Float4;
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
