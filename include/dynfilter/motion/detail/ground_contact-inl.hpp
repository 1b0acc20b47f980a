// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/motion/ground_contact.hpp>

#include <algorithm>
#include <dynfilter/core/inline.hpp>
#include <dynfilter/core/order_statistics.hpp>
#include <dynfilter/core/portable_math.hpp>

namespace dynfilter {

DYNFILTER_INLINE const std::vector<std::optional<double>>& GroundContact::compare(
    const std::vector<GroundedPoint>& points, const FlowGroups& groups, const GroundView& view) {
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

inline bool GroundContact::find_ground() {
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

inline std::optional<double> GroundContact::farther(std::size_t k) {
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

inline bool GroundContact::ground_seen_at(double below_px) const {
  const auto from = std::lower_bound(ground_rows_.begin(), ground_rows_.end(), below_px / kSameRow);
  const auto to = std::upper_bound(from, ground_rows_.end(), below_px * kSameRow);
  return to - from >= static_cast<std::ptrdiff_t>(kGroup);
}

inline void GroundContact::extend_sunken_part(const Members& group) {
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

inline std::optional<double> GroundContact::nearer(const Members& group) {
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

inline std::optional<GroundContact::Foot> GroundContact::foot_of(const Members& group) {
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

inline int GroundContact::ground_beneath(const Foot& foot) const {
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

}  // namespace dynfilter
