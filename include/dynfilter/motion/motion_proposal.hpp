// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/geometry/rigid_motion.hpp>

namespace dynfilter {

/// One rigid motion that some of the points follow.
struct MotionProposal {
  enum class From { Expected, Predicted, Support };
  From from = From::Support;
  RigidMotion motion;
  double sigma_px = 0;  ///< noise that it was fitted with
  double area = 0;      ///< share of the visible surface that it explains best
  double order = 0.5;   ///< share of the neighbouring points of other motions that are nearer
  double score = 0;     ///< log-probability of being the background, up to a constant
};

}  // namespace dynfilter
