// SPDX-License-Identifier: MIT
#include "render/route.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

namespace dynfilter::render {

Route::Route(const Eigen::Vector2d& start, double heading_rad, std::vector<Piece> pieces)
    : pieces_(std::move(pieces)), end_{start, heading_rad} {
  for (const Piece& piece : pieces_) {
    starts_.push_back(end_);
    end_ = moved(end_, piece.length_m, piece.curvature_per_m);
  }
}

inline Route::Place Route::moved(const Place& from, double length_m, double curvature_per_m) {
  const double turn_rad = length_m * curvature_per_m, middle = from.heading_rad + turn_rad / 2;
  const double chord_m = std::abs(turn_rad) < 1e-9 ? length_m : 2 * std::sin(turn_rad / 2) / curvature_per_m;
  return {from.at + chord_m * Eigen::Vector2d(-std::sin(middle), std::cos(middle)),
          from.heading_rad + turn_rad};
}

Route::Place Route::place(double s_m) const {
  if (s_m < 0) return moved(starts_.empty() ? end_ : starts_.front(), s_m, 0);
  for (std::size_t i = 0; i < pieces_.size(); ++i) {
    if (s_m < pieces_[i].length_m) return moved(starts_[i], s_m, pieces_[i].curvature_per_m);
    s_m -= pieces_[i].length_m;
  }
  return moved(end_, s_m, 0);
}

Travel city_travel(double phase_rad) {
  constexpr double kMean_mps = 11, kSwing_mps = 2.6, kPeriod_s = 9;
  const double rate = 2 * M_PI / kPeriod_s;
  return [phase_rad, rate](double time_s) {
    return kMean_mps * time_s +
           kSwing_mps / rate * (std::cos(phase_rad) - std::cos(rate * time_s + phase_rad));
  };
}

Travel steady_travel(double speed_mps, double offset_m) {
  return [=](double time_s) { return offset_m + speed_mps * time_s; };
}

Travel looping_travel(double speed_mps, double offset_m, double begin_m, double loop_m) {
  return [=](double time_s) {
    const double s = (offset_m + speed_mps * time_s - begin_m) / loop_m;
    return begin_m + loop_m * (s - std::floor(s));
  };
}

Travel turning_travel(double slow_from_m, double slow_to_m) {
  constexpr double kFast_mps = 9, kSlow_mps = 4.5, kBrake_m = 18, kStep_s = 0.01, kBefore_s = 2,
                   kMost_s = 120;
  const auto speed = [=](double s_m) {
    const double off = std::max({0.0, slow_from_m - s_m, s_m - slow_to_m}) / kBrake_m;
    const double ease = off >= 1 ? 1 : off * off * (3 - 2 * off);
    return kSlow_mps + (kFast_mps - kSlow_mps) * ease;
  };
  std::vector<double> travelled{-kFast_mps * kBefore_s};
  while (static_cast<double>(travelled.size()) * kStep_s < kMost_s)
    travelled.push_back(travelled.back() + kStep_s * speed(travelled.back()));
  return [travelled](double time_s) {
    const double at =
        std::clamp((time_s + kBefore_s) / kStep_s, 0.0, static_cast<double>(travelled.size() - 2));
    const auto i = static_cast<std::size_t>(at);
    return travelled[i] + (at - static_cast<double>(i)) * (travelled[i + 1] - travelled[i]);
  };
}

Eigen::Isometry3d Driving::pose(double time_s) const {
  const double s = travel_(time_s);
  const Eigen::Vector2d p = route_->at(s);
  return frame_at({p.x(), p.y(), 0}, turn(route_->heading_rad(s), Eigen::Vector3d::UnitZ()));
}

void Driving::pose(double time_s, std::vector<Eigen::Isometry3d>& parts) const {
  parts.assign(1, pose(time_s));
}

}  // namespace dynfilter::render
