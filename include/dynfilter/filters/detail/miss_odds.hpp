// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <dynfilter/filters/detail/miss_noise.hpp>
#include <dynfilter/filters/detail/track_misses.hpp>
#include <dynfilter/motion/moving_odds.hpp>
#include <dynfilter/motion/patch_relief.hpp>
#include <limits>

namespace dynfilter::detail {

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
