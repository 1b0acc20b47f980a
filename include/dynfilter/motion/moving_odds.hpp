// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <dynfilter/core/portable_math.hpp>

namespace dynfilter {

/// A miss against the background's motion, and what it is compared with.
struct MovingOddsInput {
  double chi2 = 0;  ///< of the whole miss under the static hypothesis
  /// Squares of its parts in the image across the edge of the match and along it (core/frame_view.hpp).
  double across2_px2 = 0, along2_px2 = 0;
  double sigma_px = 1;       ///< noise of the image part across the edge
  double along = 1;          ///< variance along the edge over that across it
  double sigma_depth_m = 1;  ///< noise of one depth
  double px_per_m = 1;       ///< focal length over depth
  double elapsed_s = 0;      ///< between the two frames
  int image_axes = 2;        ///< 1: across a line only
  bool depth_axis = true;    ///< false: the image only
};

/// Log-likelihood ratio [nats] of a feature that moves against one that stands still. No prior is in it.
///
/// Static: the miss has a Student t density with nu = 6 and the stated noise. Moving at a speed of standard
/// deviation v: the variance of each axis grows by (v elapsed)^2, in pixels or metres. Of the n axes m are in
/// the image. c is the static chi2, c_v the chi2 under the wider density. a and b are the ratios of the added
/// to the static variance in the image and in depth.
///   odds_v = (nu + n) / 2 (log(1 + c / nu) - log(1 + c_v / nu)) - m log(1 + a) / 2 - log(1 + b) / 2
///   odds   = log(mean of exp(odds_v) over both speeds, weighted by their shares)
/// Where the noise is larger than anything a mover could do in that time, a and b vanish and nothing is said:
/// a blurred frame is evidence for neither. The units are seconds, whatever the rate. About 0.03 us.
class MovingOdds {
 public:
  static constexpr double kSlow_mps = 0.05, kFast_mps = 1.0;  ///< standard deviations of a mover's speed
  static constexpr double kFastShare = 0.6;                   ///< of movers

  double operator()(const MovingOddsInput& in) const {
    const double per_s2 = 1 / (in.sigma_px * in.sigma_px);
    const double across2 = in.across2_px2 * per_s2, along2 = in.along2_px2 * per_s2;
    const double image2 = across2 + along2 / in.along;
    const double depth2 = in.depth_axis ? std::max(0.0, in.chi2 - image2) : 0;
    const double fixed = 1 + in.chi2 / kNu;
    double sum = 0;
    for (const bool fast : {false, true}) {
      const double moved_m = (fast ? kFast_mps : kSlow_mps) * in.elapsed_s, moved_px = moved_m * in.px_per_m;
      const double a = moved_px * moved_px * per_s2;
      const double b = in.depth_axis ? moved_m * moved_m / (2 * in.sigma_depth_m * in.sigma_depth_m) : 0;
      const double image = in.depth_axis ? across2 / (1 + a) + along2 / (in.along + a) : in.chi2 / (1 + a);
      const double wide = image + depth2 / (1 + b);
      const double ratio = fixed / (1 + wide / kNu);
      const double root = std::sqrt(ratio);
      sum += (fast ? kFastShare : 1 - kFastShare) * to_half_of(ratio, root, in) /
             std::sqrt((1 + a) * (in.image_axes == 2 ? 1 + a / in.along : 1) * (1 + b));
    }
    return portable::log(std::max(kLeast, sum));
  }

 private:
  /// To the power of (nu + axes) / 2.
  static double to_half_of(double ratio, double root, const MovingOddsInput& in) {
    const double ratio2 = ratio * ratio;
    double power = ratio2 * ratio;
    for (int axis = in.depth_axis ? -1 : 0; axis < in.image_axes; ++axis) power *= root;
    return power;
  }

  static constexpr double kNu = 6;         ///< tails of real misses, fitted
  static constexpr double kLeast = 1e-30;  ///< no logarithm of zero
};

/// What the frames of a track say of its motion [nats]: log-likelihood ratios of motion against rest
/// (MovingOdds), which fade. The prior is no part of it. It is added once, by the reader:
///   belief = prior + evidence,   evidence = fade * evidence + gain * ratio,   fade = exp(-elapsed / memory)
/// So ratios of 0 lead back to the prior. Who rests seldom sets off: rest is remembered longer. Ratios look
/// back by 0.2 s, so frames less than 1/30 s apart tell the same: gain = min(1, (1 - fade) / that at 30 Hz).
class TrackEvidence {
 public:
  static constexpr double kMotion_s = 0.06, kRest_s = 0.1;  ///< memory of evidence above 0, and below
  static constexpr float kLeast = -4, kMost = 13;           ///< what is sure is overcome in some frames
  static constexpr double kFreshAt30Hz = 0.4262;            ///< 1 - exp(-1 / (30 kMotion_s))
  /// `elapsed_s`: since the last frame.
  explicit TrackEvidence(double elapsed_s)
      : moved_(static_cast<float>(portable::exp(-elapsed_s / kMotion_s))),
        rested_(static_cast<float>(portable::exp(-elapsed_s / kRest_s))),
        gain_(std::min(1.0F, (1 - moved_) / static_cast<float>(kFreshAt30Hz))) {}

  /// What is left of the last frame's.
  float faded(float evidence) const { return (evidence > 0 ? moved_ : rested_) * evidence; }
  /// `faded`, and a ratio of this frame, up to `most`: an error that stays the same must not add up.
  float with(float faded, float ratio, float most = kMost) const {
    return std::clamp(faded + gain_ * ratio, kLeast, std::max(faded, most));
  }

 private:
  float moved_, rested_, gain_;
};

}  // namespace dynfilter
