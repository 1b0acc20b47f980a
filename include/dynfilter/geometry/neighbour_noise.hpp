// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <dynfilter/core/order_statistics.hpp>
#include <dynfilter/core/point_grid.hpp>
#include <dynfilter/core/span.hpp>
#include <dynfilter/geometry/pack.hpp>
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
/// error of the motion, of the calibration and of the clock, and also the motion of the object they are on;
/// what differs between them is the noise of each. So the estimate needs neither the right motion nor a
/// majority of static points.
///
/// The squared difference of two misses with variance s^2 per axis is exponential with mean 4 s^2, so its
/// median is 4 s^2 ln 2. On one axis its median is 0.4549 times 2 s^2 (chi-square, one degree of freedom).
/// O(n), about 60 us for 1000 points. Owns its scratch.
class NeighbourNoise {
 public:
  static constexpr std::size_t kMinPairs = 20;
  /// Whole error over the noise that neighbours do not share, at most. Larger misses that neighbours agree on
  /// are motion.
  static constexpr double kMostShared = 4;

  /// The noise in units of `predicted_px`: 1 where the prediction is right. None with fewer than kMinPairs
  /// pairs. Does not depend on the order of the misses.
  std::optional<double> scale(Span<const Miss> misses, float reach_px, MissAxes axes = MissAxes::Two) {
    places_.clear();
    for (const Miss& miss : misses) places_.push_back(miss.place_px);
    grid_.build(Span<const cv::Point2f>(places_), reach_px);
    lay_out(misses);
    differences_.clear();
    for (std::size_t k = 0; k < misses.size(); ++k)
      if (const int other = nearest(misses, k, reach_px); other >= 0)
        compare(misses[k], misses[static_cast<std::size_t>(other)]);
    if (differences_.size() < kMinPairs) return std::nullopt;
    return std::sqrt(static_cast<double>(median_in_place(differences_)) / median_chi2(axes));
  }

  /// The same with what neighbours share (calibration, clock, blur): the median miss, within
  /// [1, kMostShared] times scale(). As long as less than half of the misses are those of movers it measures
  /// the static ones; beyond that the bound holds.
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
  static constexpr float kMinApart_px = 3;     ///< nearer ones are nearly the same patch
  static constexpr float kSameSurface = 0.1F;  ///< depths that differ by no more than this share

  static double median_chi2(MissAxes axes) { return axes == MissAxes::One ? 0.4549 : 2 * std::log(2.0); }

  using Four = detail::Pack::Four;
  using Mask = std::int32_t __attribute__((vector_size(16)));
  static constexpr std::size_t kLanes = 4;
  static constexpr Four kLane{0, 1, 2, 3};

  /// One array per number, sorted by grid cell, so that nearest() reads four at once.
  void lay_out(Span<const Miss> misses) {
    const std::size_t n = grid_.entries().size();
    for (std::vector<float>* column : {&x_, &y_, &depth_m_}) column->resize(n + kLanes);
    for (std::size_t e = 0; e < n; ++e) {
      const Miss& miss = misses[static_cast<std::size_t>(grid_.entries()[e])];
      x_[e] = miss.place_px.x, y_[e] = miss.place_px.y, depth_m_[e] = miss.depth_m;
    }
  }
  static Four load(const std::vector<float>& column, std::size_t at) {
    Four four;
    std::memcpy(&four, column.data() + at, sizeof four);
    return four;
  }

  /// Index of the nearest neighbour on the same surface; -1: none.
  int nearest(Span<const Miss> misses, std::size_t k, float reach_px) const {
    const Miss& miss = misses[k];
    const float limit_m = kSameSurface * miss.depth_m;
    Four best2 = Four{} + reach_px * reach_px, best = Four{} - 1;
    Mask tie{};
    grid_.ranges_around(miss.place_px, reach_px, [&](std::size_t begin, std::size_t end) {
      for (std::size_t e = begin; e < end; e += kLanes) {
        const Four dx = load(x_, e) - miss.place_px.x, dy = load(y_, e) - miss.place_px.y;
        const Four apart2 = dx * dx + dy * dy, deeper_m = load(depth_m_, e) - miss.depth_m;
        const Mask off = (apart2 > best2) | (apart2 < kMinApart_px * kMinApart_px) | (deeper_m > limit_m) |
                         (deeper_m < -limit_m) | (kLane >= static_cast<float>(end - e));
        tie |= ~off & (apart2 == best2);
        best2 = off ? best2 : apart2;
        best = off ? best : kLane + static_cast<float>(e);
      }
    });
    int lane = 0;
    for (int other = 1; other < static_cast<int>(kLanes); ++other) {
      if (best[other] >= 0 && best[lane] >= 0) tie[0] |= best2[other] == best2[lane] ? 1 : 0;
      lane = best2[other] < best2[lane] ? other : lane;
    }
    if ((tie[0] | tie[1] | tie[2] | tie[3]) != 0) return nearest_of_equals(misses, k, reach_px);
    return best[lane] < 0 ? -1 : grid_.entries()[static_cast<std::size_t>(best[lane])];
  }
  /// The same, one after the other, where equal distances occurred: the position decides.
  int nearest_of_equals(Span<const Miss> misses, std::size_t k, float reach_px) const {
    const Miss& miss = misses[k];
    float best2 = reach_px * reach_px;
    int best = -1;
    grid_.around(miss.place_px, reach_px, [&](std::int32_t j) {
      const Miss& other = misses[static_cast<std::size_t>(j)];
      const cv::Point2f apart = other.place_px - miss.place_px;
      const float apart2 = apart.dot(apart);
      if (apart2 > best2 || apart2 < kMinApart_px * kMinApart_px) return;
      if (std::abs(other.depth_m - miss.depth_m) > kSameSurface * miss.depth_m) return;
      if (apart2 == best2 && best >= 0 && !before(other, misses[static_cast<std::size_t>(best)])) return;
      best2 = apart2;
      best = j;
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
  std::vector<float> x_, y_, depth_m_;  ///< sorted by grid cell
  std::vector<cv::Point2f> places_;
  std::vector<float> differences_;
};

}  // namespace dynfilter
