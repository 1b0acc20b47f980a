// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <dynfilter/core/camera.hpp>
#include <dynfilter/core/span.hpp>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <vector>

namespace dynfilter {

struct DepthGrowthParams {
  /// Relative depth step between neighbouring pixels that counts as a jump.
  double max_step_share = 0.015;
  /// 3-D distance from the seed that a pixel was grown from; 0: no limit.
  double max_reach_m = 0.5;
};

/// Grows seeds over a depth image and stops at depth jumps.
/// It extends the features of a moving object to its pixels.
/// Zhou et al. (section 3.2.2) use this for maps, DynaSLAM without a limit on the reach for masks.
/// Growth also covers surfaces that touch the object without a jump, such as the floor under feet.
/// max_reach_m limits this.
/// Cost: linear in the grown pixels, plus clearing the mask.
/// Nothing is allocated after the first image of a size.
class DepthGrowth {
 public:
  explicit DepthGrowth(const DepthGrowthParams& params = DepthGrowthParams()) : params_(params) {}

  void set_max_reach_m(double reach_m) { params_.max_reach_m = reach_m; }

  /// `depth`: CV_32FC1 or CV_16UC1 in units of `unit_m`; any other type grows nothing.
  /// `seeds_px`: pixels of `depth`. Seeds outside the image or without depth are skipped.
  /// `mask` becomes CV_8UC1 of the same size, 255 where grown.
  /// `rivals_px`: seeds of the surroundings, such as static features.
  /// All seeds grow at the same rate, and the first one to reach a pixel owns it.
  /// The floor under feet is therefore left to the seeds on the floor.
  /// Without a valid camera, the reach has no limit. Distortion is neglected.
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

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/cluster/detail/depth_growth-inl.hpp>
#endif
