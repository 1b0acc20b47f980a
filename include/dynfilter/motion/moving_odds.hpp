// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <dynfilter/core/portable_math.hpp>

namespace dynfilter {

/// What is assumed of movers, and of a static match's errors.
struct MovingOddsModel {
  double slow_mps = 0.05, fast_mps = 1.0;  ///< standard deviations of a mover's speed, equally likely
  double moving_share = 0.05;              ///< of features that move, before anything was seen
};

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

/// Log-odds [nats] that a feature moves rather than stands still.
///
/// Static: the miss has a Student t density with nu = 6 and the stated noise. Moving at a speed of standard
/// deviation v: the variance of each axis grows by (v elapsed)^2, in pixels or metres. Of the n axes m are in
/// the image. c is the static chi2, c_v the chi2 under the wider density. a and b are the ratios of the added
/// to the static variance in the image and in depth.
///   odds_v = (nu + n) / 2 (log(1 + c / nu) - log(1 + c_v / nu)) - m log(1 + a) / 2 - log(1 + b) / 2
///   odds   = log(mean of exp(odds_v) over both speeds) + log(share / (1 - share))
/// Where the noise is larger than anything a mover could do in that time, a and b vanish and nothing is said:
/// a blurred frame is evidence for neither. The units are seconds, so cameras of 10 and 60 Hz behave alike.
/// About 0.03 us.
class MovingOdds {
 public:
  /// The shares and speeds are those of `model`.
  explicit MovingOdds(const MovingOddsModel& model = {})
      : model_(model), prior_(portable::log_odds(model.moving_share)) {}

  double operator()(const MovingOddsInput& in) const {
    const double per_s2 = 1 / (in.sigma_px * in.sigma_px);
    const double across2 = in.across2_px2 * per_s2, along2 = in.along2_px2 * per_s2;
    const double image2 = across2 + along2 / in.along;
    const double depth2 = in.depth_axis ? std::max(0.0, in.chi2 - image2) : 0;
    const double fixed = 1 + in.chi2 / kNu;
    double sum = 0;
    for (const double speed_mps : {model_.slow_mps, model_.fast_mps}) {
      const double moved_m = speed_mps * in.elapsed_s, moved_px = moved_m * in.px_per_m;
      const double a = moved_px * moved_px * per_s2;
      const double b = in.depth_axis ? moved_m * moved_m / (2 * in.sigma_depth_m * in.sigma_depth_m) : 0;
      const double image = in.depth_axis ? across2 / (1 + a) + along2 / (in.along + a) : in.chi2 / (1 + a);
      const double wide = image + depth2 / (1 + b);
      const double ratio = fixed / (1 + wide / kNu);
      const double root = std::sqrt(ratio);
      sum += to_half_of(ratio, root, in) /
             std::sqrt((1 + a) * (in.image_axes == 2 ? 1 + a / in.along : 1) * (1 + b));
    }
    return portable::log(std::max(kLeast, sum / 2)) + prior_;
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
  MovingOddsModel model_;
  double prior_;
};

}  // namespace dynfilter
