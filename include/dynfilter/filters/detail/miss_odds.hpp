// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <dynfilter/core/order_statistics.hpp>
#include <dynfilter/filters/detail/track_misses.hpp>
#include <dynfilter/geometry/neighbour_noise.hpp>
#include <dynfilter/motion/moving_odds.hpp>
#include <dynfilter/motion/patch_relief.hpp>
#include <dynfilter/motion/rigid_background.hpp>
#include <limits>
#include <vector>

namespace dynfilter::detail {

/// What a static feature's miss is, in units of the noise that neighbours do not share: over one frame, and
/// over a track. Measured in every frame on all that did not move lately, with a depth or not: errors of rows
/// and calibration do not need one. What is usual falls fast and rises slowly: a majority that sets off must
/// not become noise of the choice.
class MissNoise {
 public:
  void reset() { *this = {}; }
  void measure(const JudgedFrame& frame, const CameraPath& path, const TrackMisses& misses,
               const std::vector<float>& mobility) {
    ratios_.reserve(frame.size());
    const double noise_px = path.noise_px(1);
    const auto is_still = [&](std::size_t i, double most) {
      const TrackMisses::Measured& step = misses.step(i);
      return step.gap > 0 && mobility[i] < RigidBackgroundScene::kMobile &&
             static_cast<double>(step.miss.image_px) < most * noise_px;
    };
    ratios_.clear();
    for (std::size_t i = 0; i < frame.size(); ++i)
      if (is_still(i, 3 * kMostStepRatio)) add(misses.step(i), noise_px);
    step_scale_ = learn(kMostStepRatio, step_ratio_);
    const double shared = std::clamp(neighbours_.scale(misses.of_tracks(), kReach_px).value_or(1),
                                     kLeastTrackScale, kMostTrackScale);
    ratios_.clear();
    for (std::size_t i = 0; i < frame.size(); ++i)
      if (misses.track(i).in_space() && is_still(i, 2 * step_scale_))
        add(misses.track(i), shared * path.noise_px(static_cast<std::size_t>(misses.track(i).gap)));
    track_scale_ = shared * learn(kMostTrackRatio, track_ratio_);
  }
  /// Of one step, as it usually is.
  double step_ratio() const { return step_ratio_; }
  /// Whole noise of a match over a gap, in this frame [px per axis].
  double sigma_px(const CameraPath& path, std::size_t gap) const {
    return (gap == 1 ? step_scale_ : track_scale_) * path.noise_px(gap);
  }

 private:
  static constexpr double kFirstStepRatio = 1.5, kFirstTrackRatio = 3;  ///< before any was measured
  static constexpr double kMostStepRatio = NeighbourNoise::kMostShared, kMostTrackRatio = 8;
  static constexpr double kLeastTrackScale = 0.5, kMostTrackScale = 3;
  static constexpr double kRatioFalls = 0.3, kRatioRises = 0.03;  ///< share learned per frame
  static constexpr double kMedianOfRayleigh = 1.18;               ///< of a miss in two axes over its sigma
  static constexpr std::size_t kMinMeasured = 20;
  static constexpr float kReach_px = 30;

  void add(const TrackMisses::Measured& measured, double noise_px) {
    ratios_.push_back(static_cast<float>(static_cast<double>(measured.miss.image_px) / noise_px));
  }
  /// From the median of ratios_; with too few, what is usual.
  double learn(double most, double& usual) {
    if (ratios_.size() < kMinMeasured) return usual;
    const double now =
        std::clamp(static_cast<double>(median_in_place(ratios_)) / kMedianOfRayleigh, 1.0, most);
    usual += (now > usual ? kRatioRises : kRatioFalls) * (now - usual);
    return now;
  }

  double step_ratio_ = kFirstStepRatio, track_ratio_ = kFirstTrackRatio;
  double step_scale_ = 1, track_scale_ = 1;  ///< in this frame
  NeighbourNoise neighbours_;
  std::vector<float> ratios_;
};

/// Log-likelihood ratios of motion of a feature's misses, for the time of one frame.
class MissOdds {
 public:
  static constexpr float kLeast = -3, kMost = 6.5F;  ///< of one frame [nats]
  static constexpr float kMostAtHole = 3;  ///< over a track: a hole of structured light lies beside outlines
  static constexpr float kLeastOnLine = -1;  ///< a mover may keep to its epipolar line

  /// All must outlive this. `depths`: noise of the frame's depths as measured.
  MissOdds(const JudgedFrame& frame, const CameraPath& path, const TrackMisses& misses,
           const MissNoise& noise, const DepthNoise& depths)
      : frame_(frame),
        path_(path),
        misses_(misses),
        noise_(noise),
        depths_(depths),
        relief_(frame.evidence.frame().depth, frame.evidence.frame().depth_unit_m) {}

  /// NaN: two surfaces in the patch explain what looks like motion, so nothing is said.
  float operator()(std::size_t i) const {
    const float now = with_relief(i, 0);
    const double per_m = now > -TrackMemory::kUnknown ? relief_per_m(i) : 0;
    if (per_m == 0) return now;
    const float explained = with_relief(i, per_m);
    return explained > -TrackMemory::kUnknown ? explained : std::numeric_limits<float>::quiet_NaN();
  }
  /// What the evidence of a track may reach: depths of stereo beside an outline stay wrong, too.
  float most_over_track(std::size_t i) const {
    if (frame_.stereo) return kMost;
    return std::isnan(frame_.depth_m(i)) ? kMostAtHole : TrackEvidence::kMost;
  }

 private:
  using Measured = TrackMisses::Measured;

  /// Who sets off shows in a step, who is slow over the track.
  float with_relief(std::size_t i, double relief_per_m) const {
    const float over_track = of(misses_.track(i), relief_per_m);
    if (misses_.is_undone(i)) return over_track;
    return std::max(of(misses_.step(i), relief_per_m), over_track);
  }
  double relief_per_m(std::size_t i) const {
    const double depth_m = frame_.depth_m(i);
    return relief_.per_m(frame_.evidence.pixels()[i], depth_m, depths_.sigma_m(depth_m));
  }
  float of(const Measured& measured, double relief_per_m) const {
    if (measured.gap == 0) return kLeast;
    const auto gap = static_cast<std::size_t>(measured.gap);
    const StaticMiss miss = misses_.model(measured.gap)(measured.then, measured.now, measured.spread);
    if (miss.axes == StaticMiss::Axes::None) return kLeast;
    const double shift_px = relief_per_m > 0 ? relief_shift_px(frame_.camera, path_.between(0, gap),
                                                               measured.now.px, relief_per_m)
                                             : 0;
    MovingOddsInput in = in_image(measured, miss, shift_px);
    in.depth_axis = measured.in_space();
    if (in.depth_axis) in.sigma_depth_m = depths_.sigma_m(static_cast<double>(measured.now.depth_m));
    in.px_per_m = static_cast<double>(miss.px_per_m);
    in.elapsed_s = path_.elapsed_s(gap);
    return std::clamp(static_cast<float>(odds_(in)), measured.on_line() ? kLeastOnLine : kLeast, kMost);
  }
  /// The part of the odds' input that is measured in the image. `shift_px`: of the patch's two surfaces.
  MovingOddsInput in_image(const Measured& measured, const StaticMiss& miss, double shift_px) const {
    MovingOddsInput in;
    in.chi2 = static_cast<double>(miss.chi2);
    in.image_axes = miss.axes == StaticMiss::Axes::Line ? 1 : 2;
    const double miss2_px2 = static_cast<double>(miss.image_px * miss.image_px);
    const double sigma_px = noise_.sigma_px(path_, static_cast<std::size_t>(measured.gap)),
                 sigma2_px2 = sigma_px * sigma_px, shift2_px2 = shift_px * shift_px;
    double across2_px2 = sigma2_px2 * measured.spread.across, along2_px2 = sigma2_px2 * measured.spread.along;
    if (in.image_axes == 1 && in.chi2 > 0)
      across2_px2 = along2_px2 = miss2_px2 / in.chi2;  // the miss's own axis
    in.chi2 *= across2_px2 / (across2_px2 + shift2_px2);
    in.sigma_px = std::sqrt(across2_px2 + shift2_px2);
    in.along = (along2_px2 + shift2_px2) / (across2_px2 + shift2_px2);
    const double along_px = static_cast<double>(miss.miss_px.dot(measured.spread.edge));
    in.along2_px2 = along_px * along_px;
    in.across2_px2 = std::max(0.0, miss2_px2 - in.along2_px2);
    return in;
  }

  const JudgedFrame& frame_;
  const CameraPath& path_;
  const TrackMisses& misses_;
  const MissNoise& noise_;
  DepthNoise depths_;
  PatchRelief relief_;
  MovingOdds odds_;
};

}  // namespace dynfilter::detail
