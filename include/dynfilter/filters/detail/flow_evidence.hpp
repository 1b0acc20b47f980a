// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <dynfilter/core/order_statistics.hpp>
#include <dynfilter/core/portable_math.hpp>
#include <dynfilter/core/span.hpp>
#include <dynfilter/evidence/evidence.hpp>
#include <dynfilter/filters/detail/gap_flow.hpp>
#include <dynfilter/motion/expiring.hpp>
#include <utility>
#include <vector>

namespace dynfilter::detail {

/// What the tracks' flow says of motion [standard deviations], averaged over time and over groups.
class FlowEvidence {
 public:
  static constexpr double kLimit = 2.0;     ///< largest deviation of a static feature's flow
  static constexpr double kMemory_s = 0.5;  ///< time constant of the average of a track's evidence
  static constexpr double kMaxSigmas = 6;   ///< limits the influence of one frame

  struct Track {
    ExpiringMean flow, off_ground;
  };

  void clear() { tracks_.clear(); }
  void take_over(const FeatureTracks& tracks, double passed_s) {
    std::swap(tracks_, last_tracks_);
    const std::size_t n = tracks.size();
    tracks_.assign(n, Track());
    for (std::size_t i = 0; i < n; ++i) {
      const int previous = tracks.previous(i);
      if (previous >= 0 && static_cast<std::size_t>(previous) < last_tracks_.size())
        tracks_[i] = last_tracks_[static_cast<std::size_t>(previous)];
      tracks_[i].flow.pass(passed_s);
      tracks_[i].off_ground.pass(passed_s);
    }
    judged_.assign(n, false);
    suspicion_.assign(n, 0);
  }
  Track& operator[](std::size_t i) { return tracks_[i]; }
  bool judged(std::size_t i) const { return judged_[i]; }
  /// How far it exceeds the limit [standard deviations].
  double excess(std::size_t i) const {
    return std::min(portable::hypot(suspicion_[i], tracks_[i].off_ground.value()) - kLimit, kLimit);
  }

  /// Judges the points of a gap that no longer one has judged.
  void weigh(GapFlow& flow, const FlowView& view) {
    weigh_flows(flow, view);
    weigh_groups(flow);
    for (std::size_t k = 0; k < flow.size(); ++k) judged_[flow[k].feature] = true;
  }

 private:
  static constexpr double kNoiseOfFlow = 0.01;  ///< additional noise per pixel of flow
  static constexpr std::size_t kGroup = 4;      ///< smallest number of points

  double value(const GapFlow& flow, std::size_t k) const { return tracks_[flow[k].feature].flow.value(); }

  void weigh_flows(GapFlow& flow, const FlowView& view) {
    const double middle = flow.middle_inverse_depth(view, [&](std::size_t k) {
      return std::abs(flow[k].flow.across_px) < kLimit * flow.noise_px() && value(flow, k) < kLimit;
    });
    for (std::size_t k = 0; k < flow.size(); ++k) {
      const FlowPoint& own = flow[k];
      if (judged_[own.feature]) continue;
      values_.assign(1, own.flow.across_px / own.across_noise);
      along_.assign(1, own.flow.along_px);
      for (const int j : flow.groups().linked(k)) {
        const FlowPoint& q = flow[static_cast<std::size_t>(j)];
        values_.push_back(q.flow.across_px / q.across_noise);
        along_.push_back(q.flow.along_px);
      }
      const double across = averaged_median_in_place(values_);
      const double wrong_way =
          flow.wrong_way_px(own, averaged_median_in_place(along_), middle) / own.along_noise;
      const double sigma_px = portable::hypot(flow.noise_px(), kNoiseOfFlow * own.length_px);
      tracks_[own.feature].flow.observe(std::min(portable::hypot(across, wrong_way) / sigma_px, kMaxSigmas),
                                        kMemory_s);
    }
  }
  /// A feature in a group has the suspicion of the group. Any other feature is scaled by the share of
  /// suspects among its neighbours, because a feature that moves alone is probably a bad track.
  void weigh_groups(const GapFlow& flow) {
    for (std::size_t g = 0; g < flow.groups().size(); ++g) {
      const Span<const int> members = flow.groups().group(g);
      values_.clear();
      for (const int m : members) values_.push_back(value(flow, static_cast<std::size_t>(m)));
      const double together = averaged_median_in_place(values_);
      for (const int m : members) {
        const auto k = static_cast<std::size_t>(m);
        if (judged_[flow[k].feature]) continue;
        suspicion_[flow[k].feature] =
            members.size() >= kGroup ? together : value(flow, k) * share_of_suspects(flow, k);
      }
    }
  }
  double share_of_suspects(const GapFlow& flow, std::size_t k) const {
    const Span<const int> near = flow.groups().near(k);
    const auto suspects = std::count_if(
        near.begin(), near.end(), [&](int j) { return value(flow, static_cast<std::size_t>(j)) > kLimit; });
    return near.empty() ? 0 : static_cast<double>(suspects) / static_cast<double>(near.size());
  }

  std::vector<Track> tracks_, last_tracks_;
  std::vector<bool> judged_;  ///< over a gap of this frame
  std::vector<double> suspicion_;
  std::vector<double> values_, along_;
};

}  // namespace dynfilter::detail
