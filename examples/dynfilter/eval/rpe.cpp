// SPDX-License-Identifier: MIT
#include "eval/rpe.hpp"

#include <dynfilter/core/error.hpp>
#include <dynfilter/core/pose.hpp>

namespace dynfilter::eval {

namespace detail {

/// The closest value. A tie is decided like the binary search of the TUM tools does.
inline std::size_t closest_index(const std::vector<double>& sorted, double value) {
  std::size_t begin = 0, end = sorted.size(), best = 0;
  double gap = std::abs(sorted[0] - value);
  while (begin < end) {
    const std::size_t middle = (begin + end) / 2;
    if (std::abs(sorted[middle] - value) < gap) {
      gap = std::abs(sorted[middle] - value);
      best = middle;
    }
    if (sorted[middle] == value) return middle;
    if (sorted[middle] > value) {
      end = middle;
    } else {
      begin = middle + 1;
    }
  }
  return best;
}

std::vector<double> stamps_s(const io::Trajectory& trajectory) {
  std::vector<double> stamps;
  for (const auto& pose : trajectory) stamps.push_back(pose.timestamp_s);
  return stamps;
}

inline double median_interval_s(const std::vector<double>& stamps) {
  std::vector<double> intervals;
  for (std::size_t i = 1; i < stamps.size(); ++i) intervals.push_back(stamps[i] - stamps[i - 1]);
  return median(intervals);
}

}  // namespace detail

RpeResult relative_pose_error(const io::Trajectory& truth, const io::Trajectory& estimate, double delta_s) {
  const std::vector<double> truth_s = detail::stamps_s(truth), estimate_s = detail::stamps_s(estimate);
  const double max_gap_s = 2 * detail::median_interval_s(truth_s);
  std::vector<double> translation_m, rotation_deg;
  for (std::size_t i = 0; i < estimate.size() && !truth.empty(); ++i) {
    const std::size_t j = detail::closest_index(estimate_s, estimate_s[i] + delta_s);
    if (j + 1 == estimate.size()) continue;
    const std::size_t a = detail::closest_index(truth_s, estimate_s[i]);
    const std::size_t b = detail::closest_index(truth_s, estimate_s[j]);
    const double gap_s = std::max(std::abs(truth_s[a] - estimate_s[i]), std::abs(truth_s[b] - estimate_s[j]));
    if (!(gap_s <= max_gap_s)) continue;
    const Pose moved = inverse(estimate[j].T_world_camera) * estimate[i].T_world_camera;
    const Pose should = inverse(truth[b].T_world_camera) * truth[a].T_world_camera;
    const Pose error = inverse(moved) * should;
    translation_m.push_back(error.t().norm());
    rotation_deg.push_back(detail::angle_rad(error.R()) * 180 / 3.14159265358979323846);
  }
  if (translation_m.size() < 2) {
    throw Error(
        "the trajectories share no pairs of poses that far apart: too short, or of different recordings");
  }
  return {translation_m.size(), statistics(translation_m), statistics(rotation_deg)};
}

}  // namespace dynfilter::eval
