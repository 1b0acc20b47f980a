// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <dynfilter/core/order_statistics.hpp>
#include <dynfilter/core/point_grid.hpp>
#include <dynfilter/core/portable_math.hpp>
#include <dynfilter/core/span.hpp>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

namespace dynfilter {

/// Coordinates of a miss that a model determines.
enum class MissAxes {
  One,  ///< across a line; the other coordinate is zero
  Two   ///< of a point
};

/// What is left of a match after a motion was taken off.
struct Miss {
  cv::Point2f place_px;    ///< where the feature is
  float depth_m;           ///< finite
  cv::Point2f miss_px;     ///< measured minus predicted
  float predicted_px = 1;  ///< standard deviation that is expected per axis, > 0
};

/// Noise of matches from the differences between neighbours' misses. Neighbours on one surface share the
/// errors of motion, calibration and clock, and the motion of their object. What differs between them is the
/// noise of each. So the estimate needs neither the right motion nor a majority of static points.
///
/// The squared difference of two misses with variance s^2 per axis is exponential with mean 4 s^2, so its
/// median is 4 s^2 ln 2. On one axis its median is 0.4549 times 2 s^2 (chi-square, one degree of freedom).
/// O(n), about 60 us for 1000 points. Owns its scratch.
class NeighbourNoise {
 public:
  static constexpr std::size_t kMinPairs = 20;
  /// Whole error over the noise that neighbours do not share, at most. A larger one they agree on is motion.
  static constexpr double kMostShared = 4;

  /// The noise in units of `predicted_px`: 1 where the prediction is right. None with fewer than kMinPairs
  /// pairs. Does not depend on the order of the misses.
  std::optional<double> scale(Span<const Miss> misses, float reach_px, MissAxes axes = MissAxes::Two) {
    places_.clear();
    for (const Miss& miss : misses) places_.push_back(miss.place_px);
    grid_.build_for_nearest(Span<const cv::Point2f>(places_), reach_px / 2);
    by_place_.clear();
    for (const std::int32_t i : grid_.entries()) by_place_.push_back(misses[static_cast<std::size_t>(i)]);
    differences_.clear();
    for (const Miss& miss : by_place_)
      if (const Miss* other = nearest(miss, reach_px)) compare(miss, *other);
    if (differences_.size() < kMinPairs) return std::nullopt;
    return std::sqrt(static_cast<double>(median_in_place(differences_)) / median_chi2(axes));
  }

  /// The same with what neighbours share (calibration, clock, blur): the median miss, within [1, kMostShared]
  /// times scale(). As long as less than half of the misses are those of movers it measures the static ones;
  /// beyond that the bound holds.
  std::optional<double> whole_scale(Span<const Miss> misses, float reach_px, MissAxes axes = MissAxes::Two) {
    const std::optional<double> unshared = scale(misses, reach_px, axes);
    if (!unshared) return std::nullopt;
    differences_.clear();
    for (const Miss& miss : misses)
      differences_.push_back(miss.miss_px.dot(miss.miss_px) / (miss.predicted_px * miss.predicted_px));
    const double whole = std::sqrt(static_cast<double>(median_in_place(differences_)) / median_chi2(axes));
    return std::clamp(whole, *unshared, kMostShared * *unshared);
  }

 private:
  static constexpr float kMinApart_px = 3;       ///< nearer ones are nearly the same patch
  static constexpr float kSameSurface = 0.1F;    ///< depths that differ by no more than this share
  static constexpr double kRounding = 1 + 1e-6;  ///< of distances

  static double median_chi2(MissAxes axes) { return axes == MissAxes::One ? 0.4549 : 2 * portable::log(2.0); }

  /// The nearest neighbour on the same surface; null: none.
  const Miss* nearest(const Miss& miss, float reach_px) const {
    const float limit_m = kSameSurface * miss.depth_m;
    const Miss* best = nullptr;
    float best2 = reach_px * reach_px;
    const auto reach = [&] { return std::sqrt(static_cast<double>(best2)) * kRounding; };
    grid_.ranges_outwards(miss.place_px, reach(), [&](std::size_t begin, std::size_t end) {
      for (const Miss* other = by_place_.data() + begin; other != by_place_.data() + end; ++other) {
        const cv::Point2f apart = other->place_px - miss.place_px;
        const float apart2 = apart.dot(apart);
        if (apart2 > best2 || apart2 < kMinApart_px * kMinApart_px) continue;
        if (std::abs(other->depth_m - miss.depth_m) > limit_m) continue;
        if (apart2 == best2 && best != nullptr && !before(*other, *best)) continue;
        best2 = apart2;
        best = other;
      }
      return reach();
    });
    return best;
  }
  /// By place, so that the order of the points does not matter.
  static bool before(const Miss& a, const Miss& b) {
    return a.place_px.y != b.place_px.y ? a.place_px.y < b.place_px.y : a.place_px.x < b.place_px.x;
  }
  void compare(const Miss& a, const Miss& b) {
    const cv::Point2f d = a.miss_px - b.miss_px;
    differences_.push_back(d.dot(d) / (a.predicted_px * a.predicted_px + b.predicted_px * b.predicted_px));
  }

  PointGrid grid_;
  std::vector<Miss> by_place_;  ///< by cell, so that near ones are read together
  std::vector<cv::Point2f> places_;
  std::vector<float> differences_;
};

}  // namespace dynfilter
