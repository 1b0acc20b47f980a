// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <dynfilter/core/order_statistics.hpp>
#include <dynfilter/filters/detail/track_misses.hpp>
#include <dynfilter/geometry/neighbour_noise.hpp>
#include <dynfilter/motion/background_scene.hpp>
#include <vector>

namespace dynfilter::detail {

/// What a static feature's miss is, in units of the noise that neighbours do not share: over one frame, and
/// over a track. Measured in every frame, against what is usual: the ratio falls fast and rises slowly,
/// because a majority that sets off must not become noise.
class MissNoise {
 public:
  void reset() { *this = {}; }
  void measure(const JudgedFrame& frame, const CameraPath& path, const TrackMisses& misses,
               const std::vector<float>& mobility) {
    ratios_.reserve(frame.size());
    const double noise_px = path.noise_px(1);
    const auto ratio_of_step = [&](std::size_t i, double most) {
      const TrackMisses::Measured& step = misses.step(i);
      return step.in_space() && mobility[i] < RigidBackgroundScene::kMobile &&
             static_cast<double>(step.miss.image_px) < most * noise_px;
    };
    ratios_.clear();
    for (std::size_t i = 0; i < frame.size(); ++i)
      if (ratio_of_step(i, 3 * kMostStepRatio)) add(misses.step(i), noise_px);
    step_scale_ = usual(1, kMostStepRatio, step_ratio_);
    const double shared = std::clamp(neighbours_.scale(misses.of_tracks(), kReach_px).value_or(1),
                                     kLeastTrackScale, kMostTrackScale);
    ratios_.clear();
    for (std::size_t i = 0; i < frame.size(); ++i)
      if (misses.track(i).in_space() && ratio_of_step(i, 2 * step_scale_))
        add(misses.track(i), path.noise_px(static_cast<std::size_t>(misses.track(i).gap)));
    track_scale_ = usual(shared, kMostTrackRatio, track_ratio_);
  }
  /// Of one step, as it usually is.
  double step_ratio() const { return step_ratio_; }
  /// Whole noise of a match over a gap, in this frame [px per axis].
  double sigma_px(const CameraPath& path, std::size_t gap) const {
    return (gap == 1 ? step_scale_ : track_scale_) * path.noise_px(gap);
  }

 private:
  static constexpr double kFirstStepRatio = 1.5, kFirstTrackRatio = 3;  ///< before any was measured
  static constexpr double kLeastRatio = 1.0, kMostStepRatio = NeighbourNoise::kMostShared,
                          kMostTrackRatio = 8;
  static constexpr double kLeastTrackScale = 0.5, kMostTrackScale = 3;
  static constexpr double kRatioSlack = 1.5;  ///< a frame may exceed what is usual by this factor
  static constexpr double kRatioFalls = 0.3, kRatioRises = 0.03;  ///< share learned per frame
  static constexpr double kMedianOfRayleigh = 1.18;               ///< of a miss in two axes over its sigma
  static constexpr std::size_t kMinMeasured = 20;
  static constexpr float kReach_px = 30;

  void add(const TrackMisses::Measured& measured, double noise_px) {
    ratios_.push_back(static_cast<float>(static_cast<double>(measured.miss.image_px) / noise_px));
  }
  /// From the median of ratios_, in units of `base`.
  double usual(double base, double most, double& ratio) {
    if (ratios_.size() < kMinMeasured) return std::min(ratio, most) * base;
    const double now = std::clamp(static_cast<double>(median_in_place(ratios_)) / kMedianOfRayleigh / base,
                                  kLeastRatio, most);
    ratio += (now > ratio ? kRatioRises : kRatioFalls) * (now - ratio);
    return std::min(now, kRatioSlack * ratio) * base;
  }

  double step_ratio_ = kFirstStepRatio, track_ratio_ = kFirstTrackRatio;
  double step_scale_ = 1, track_scale_ = 1;  ///< in this frame
  NeighbourNoise neighbours_;
  std::vector<float> ratios_;
};

}  // namespace dynfilter::detail
