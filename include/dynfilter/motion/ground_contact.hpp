// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <dynfilter/core/order_statistics.hpp>
#include <dynfilter/core/portable_math.hpp>
#include <dynfilter/motion/expiring.hpp>
#include <dynfilter/motion/flow_groups.hpp>
#include <dynfilter/motion/ground_plane.hpp>
#include <optional>
#include <vector>

namespace dynfilter {

/// A point that is compared with the ground.
struct GroundedPoint {
  GroundPoint at;
  double x_px = 0, y_px = 0;  ///< from the principal point
  double line_px = 1;  ///< flow per inverse depth: the noise of the inverse depth is noise_px / line_px
  bool shows_ground = false;  ///< follows the static scene otherwise
};

/// The frame in which points are compared with the ground.
struct GroundView {
  double gap_s = 0;       ///< over which the points moved
  double height_px = 0;   ///< of the image
  double focus_y_px = 0;  ///< of the focus of expansion, from the principal point: on the horizon
  double noise_px = 0;    ///< of the flow
  double limit = 2;       ///< [sigma] from which evidence counts
  double most = 6;        ///< [sigma] of one frame
};

/// Finds movers that a forward moving camera sees move along their epipolar lines. Over a flat ground of
/// which the camera is one height above, a point `below` the horizon has at least the inverse depth scale *
/// below.
///
/// Farther: a car that drives ahead hardly flows, so it seems to be beneath the ground:
///   sigmas = (1 - inverse_depth / (scale * below)) / hypot(0.15, noise / (line * scale * below)).
///   Each point is compared together with neighbours of similar flow; a group has the evidence of its lower
///   part, up to the height of a van. The ground must be seen at this distance: a road may bend downwards.
/// Nearer: an oncoming car flows too fast, so its lower end seems to hover:
///   sigmas = limit + log(ratio of the group's lowest tenth / 1.2 / (1 + 1 / n)) / 0.15.
///   Only for upright groups whose lower end is in the image. If the group was static and hovered by
///   occlusion, the ground between its lower end and the place where it would stand is hidden. So ground must
///   be seen there, or the group be large with nothing nearer in front of it.
/// Blind to: slopes whose ground is seen (a hill's near side); movers above the horizon.
/// Cost: 0.1 ms for 1000 points, without finding the ground (0.2 ms).
class GroundContact {
 public:
  void reset() { ground_.reset(); }
  /// A frame begins, `passed_s` after the last one: ground that no frame shows is forgotten.
  void pass(double passed_s) { ground_.pass(passed_s); }
  /// The plane that was seen last; nullopt: none.
  const std::optional<GroundPlane>& ground() const { return ground_.value(); }

  /// Standard deviations by which each point is off the ground; nullopt: it cannot be compared.
  /// Empty if no ground is found.
  const std::vector<std::optional<double>>& compare(const std::vector<GroundedPoint>& points,
                                                    const FlowGroups& groups, const GroundView& view) {
    points_ = &points;
    groups_ = &groups;
    view_ = view;
    sigmas_.clear();
    if (!find_ground()) return sigmas_;
    ground_rows_.clear();
    for (const GroundedPoint& p : points)
      if (p.shows_ground && is_ground(p)) ground_rows_.push_back(below(p));
    std::sort(ground_rows_.begin(), ground_rows_.end());
    sigmas_.resize(points.size());
    for (std::size_t k = 0; k < points.size(); ++k) sigmas_[k] = farther(k);
    for (std::size_t g = 0; g < groups.size(); ++g) {
      const Members& group = groups.group(g);
      if (group.size() < kGroup) continue;
      const std::optional<double> above = nearer(group);
      extend_sunken_part(group);
      if (!above) continue;
      for (const int m : group) {
        std::optional<double>& sigmas = sigmas_[static_cast<std::size_t>(m)];
        sigmas = std::max(*above, sigmas.value_or(0));
      }
    }
    return sigmas_;
  }

 private:
  static constexpr double kGroundSmoothing = 0.5;  ///< weight of a new frame's ground
  /// [heights] smallest distance below the horizon of points that show the ground.
  static constexpr double kGroundBelow = 0.08;
  /// [heights] smallest distance below the horizon of points compared with the ground.
  static constexpr double kLeastBelow = 0.04;
  static constexpr std::size_t kGroup = 4;  ///< smallest number of points
  static constexpr std::size_t kFew = 3;    ///< values of which a median is taken, at least
  /// Ratios to the ground's inverse depth. The ground's own spread on real streets is 0.9 to 1.15.
  static constexpr double kLeastGround = 0.8, kMostGround = 1.2;
  static constexpr double kRatioSigma = 0.15;  ///< of the logarithm of the ratio
  static constexpr double kOnGround = 1;       ///< [sigma] nearer to the ground than that: on it
  static constexpr double kSameRow = 1.4;      ///< ratio of rows at which the ground must be seen
  // Farther than the ground.
  static constexpr double kSunkenShare = 0.3;  ///< of the points beside: higher ones differ less
  static constexpr double kBeside_px = 8;
  static constexpr double kTallest = 1.6;  ///< heights of the camera above the ground: a van
  // Nearer than the ground.
  static constexpr double kEdge = 0.03;       ///< [heights] this close to the lower edge it is cut off
  static constexpr double kFlat = 0.5;        ///< inverse depth ~ rows^slope: 0 for upright, 1 for ground
  static constexpr double kFoot = 0.1;        ///< quantile of a group's ratios
  static constexpr double kInFront = 1.25;    ///< ratio of inverse depths from which a point hides others
  static constexpr double kBelowFoot_px = 8;  ///< beneath is what the foot's own patch does not cover
  static constexpr std::size_t kLarge = 12;   ///< points of a group that needs no ground beneath it
  /// Ratio of a lower end at a quarter of the camera's height: the bumper of a parked car whose wheels show
  /// no points.
  static constexpr double kHighestEnd = 4.0 / 3;

  using Members = Span<const int>;
  const GroundedPoint& point(int m) const { return (*points_)[static_cast<std::size_t>(m)]; }
  double below(const GroundedPoint& p) const { return ground()->below(p.at.x, p.at.y); }
  double ratio(const GroundedPoint& p) const { return p.at.inverse_depth / (ground()->scale * below(p)); }
  bool is_ground(const GroundedPoint& p) const {
    const double r = ratio(p);
    return below(p) > 0 && r > kLeastGround && r < kMostGround;
  }

  bool find_ground() {
    shown_.clear();
    for (const GroundedPoint& p : *points_)
      if (p.shows_ground) shown_.push_back(p.at);
    GroundPlaneFinder::Options options;
    options.min_below_px = kGroundBelow * view_.height_px;
    const std::optional<GroundPlane> found = finder_.find(shown_, options);
    std::optional<GroundPlane> plane = ground();
    if (plane) plane->scale *= view_.gap_s / ground_s_;  // in units of the camera's step
    ground_s_ = view_.gap_s;
    if (!found) {
      if (plane) ground_.infer(*plane, ground_.since_s());
      return plane.has_value();
    }
    if (!plane) plane = GroundPlane{found->scale, 0};
    plane->scale += kGroundSmoothing * (found->scale - plane->scale);
    plane->tilt += kGroundSmoothing * (found->tilt - plane->tilt);
    ground_.confirm(*plane);
    return true;
  }
  std::optional<double> farther(std::size_t k) {
    values_.clear();
    rows_.clear();
    const auto compare = [&](std::size_t j) {
      const GroundedPoint& p = (*points_)[j];
      const double below_px = below(p), expected = ground()->scale * below_px;
      if (!(below_px > kLeastBelow * view_.height_px)) return;
      const double noise = view_.noise_px / (std::max(1.0, p.line_px) * expected);
      values_.push_back((1 - p.at.inverse_depth / expected) / portable::hypot(kRatioSigma, noise));
      rows_.push_back(below_px);
    };
    compare(k);
    for (const int j : groups_->linked(k)) compare(static_cast<std::size_t>(j));
    if (values_.size() < kFew) return std::nullopt;
    const double sigmas = averaged_median_in_place(values_);
    if (!(sigmas > -kOnGround)) return std::nullopt;
    if (!(sigmas > kOnGround)) return 0.0;
    if (!ground_seen_at(averaged_median_in_place(rows_))) return std::nullopt;
    return std::min(sigmas, view_.most);
  }
  bool ground_seen_at(double below_px) const {
    const auto from = std::lower_bound(ground_rows_.begin(), ground_rows_.end(), below_px / kSameRow);
    const auto to = std::upper_bound(from, ground_rows_.end(), below_px * kSameRow);
    return to - from >= static_cast<std::ptrdiff_t>(kGroup);
  }
  /// The lower part of a body that seems to be beneath the ground speaks for all of it.
  void extend_sunken_part(const Members& group) {
    values_.clear();
    double left_px = 0, right_px = 0, foot_px = 0, height_px = 0;
    for (const int m : group) {
      const std::optional<double>& sigmas = sigmas_[static_cast<std::size_t>(m)];
      if (!(sigmas.value_or(0) > view_.limit)) continue;
      const GroundedPoint& p = point(m);
      const bool first = values_.empty();
      left_px = first ? p.x_px : std::min(left_px, p.x_px);
      right_px = first ? p.x_px : std::max(right_px, p.x_px);
      if (first || p.y_px > foot_px) foot_px = p.y_px, height_px = below(p);
      values_.push_back(*sigmas);
    }
    if (values_.size() < kFew) return;
    const auto beside = [&](int m, double margin_px) {
      return point(m).x_px >= left_px - margin_px && point(m).x_px <= right_px + margin_px;
    };
    const auto compared = std::count_if(group.begin(), group.end(), [&](int m) {
      return beside(m, 0) && sigmas_[static_cast<std::size_t>(m)].has_value();
    });
    if (static_cast<double>(values_.size()) < kSunkenShare * static_cast<double>(compared)) return;
    const double together = averaged_median_in_place(values_);
    for (const int m : group) {
      if (!beside(m, kBeside_px) || point(m).y_px < foot_px - kTallest * height_px) continue;
      std::optional<double>& sigmas = sigmas_[static_cast<std::size_t>(m)];
      sigmas = std::max(together, sigmas.value_or(0));
    }
  }

  std::optional<double> nearer(const Members& group) {
    const std::optional<Foot> foot = foot_of(group);
    if (!foot) return std::nullopt;
    if (!(foot->ratio > 0)) return 0.0;
    const int free = ground_beneath(*foot);
    const double highest = free > 0 ? kMostGround : kHighestEnd;
    const double limit = highest * (1 + 1 / static_cast<double>(values_.size()));
    const double sigmas =
        std::clamp(view_.limit + portable::log(foot->ratio / limit) / kRatioSigma, 0.0, view_.most);
    if (sigmas > 0 && (free < 0 || (free == 0 && group.size() < kLarge))) return std::nullopt;
    return sigmas;
  }
  /// The lower end of the group, its extent, and its ratio to the ground.
  struct Foot {
    double left_px, right_px, y_px, ratio;
  };
  std::optional<Foot> foot_of(const Members& group) {
    values_.clear();
    Foot foot{1e9, -1e9, -1e9, 0};
    double sx = 0, sy = 0, sxx = 0, sxy = 0, n = 0;  // of the logarithms of rows and inverse depths
    for (const int m : group) {
      const GroundedPoint& p = point(m);
      foot.y_px = std::max(foot.y_px, p.y_px);
      foot.left_px = std::min(foot.left_px, p.x_px);
      foot.right_px = std::max(foot.right_px, p.x_px);
      const double below_px = below(p);
      if (!(below_px > kLeastBelow * view_.height_px)) continue;
      values_.push_back(ratio(p));
      if (!(p.at.inverse_depth > 0)) continue;
      const double x = portable::log(below_px), y = portable::log(p.at.inverse_depth);
      sx += x, sy += y, sxx += x * x, sxy += x * y, ++n;
    }
    if (2 * values_.size() < group.size() || n < 3) return std::nullopt;
    if (foot.y_px > (0.5 - kEdge) * view_.height_px) return std::nullopt;
    if (sxy - sx * sy / n > kFlat * (sxx - sx * sx / n)) return std::nullopt;
    const auto lowest =
        values_.begin() + static_cast<std::ptrdiff_t>(kFoot * static_cast<double>(values_.size()));
    std::nth_element(values_.begin(), lowest, values_.end());
    foot.ratio = *lowest;
    return foot;
  }
  /// Number of ground points between the lower end and where it would stand, less the points in front.
  int ground_beneath(const Foot& foot) const {
    const double foot_below_px = foot.y_px - view_.focus_y_px;
    int free = 0;
    for (const GroundedPoint& p : *points_) {
      if (p.x_px < foot.left_px || p.x_px > foot.right_px || p.y_px < foot.y_px + kBelowFoot_px) continue;
      if (p.y_px - view_.focus_y_px > foot_below_px * foot.ratio) continue;
      if (is_ground(p)) ++free;
      if (p.at.inverse_depth > kInFront * foot.ratio * ground()->scale * foot_below_px) --free;
    }
    return free;
  }

  GroundPlaneFinder finder_;
  Expiring<GroundPlane> ground_;
  double ground_s_ = 0;  ///< the gap in whose steps its scale is
  GroundView view_;
  const std::vector<GroundedPoint>* points_ = nullptr;
  const FlowGroups* groups_ = nullptr;
  std::vector<GroundPoint> shown_;
  std::vector<std::optional<double>> sigmas_;
  std::vector<double> values_, rows_;
  std::vector<double> ground_rows_;  ///< [px] below the horizon, where ground is seen; sorted
};

}  // namespace dynfilter
