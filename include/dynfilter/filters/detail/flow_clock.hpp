// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <dynfilter/evidence/evidence.hpp>
#include <dynfilter/motion/prior_evidence.hpp>
#include <dynfilter/motion/view_motion_search.hpp>
#include <optional>
#include <vector>

namespace dynfilter::detail {

/// The times of the recent frames, and what a motion prior said of each step. Gaps count frames backwards.
class FlowClock {
 public:
  static constexpr int kMostFrames = 30;  ///< longest gap over which flow is measured

  /// The gaps that a frame is judged over, the longest first.
  struct Gaps {
    std::vector<int> all;
    int ground = 0;  ///< one of them
  };

  void reset() {
    ages_s_.clear();
    steps_.clear();
  }
  void pass(const Evidence& evidence, const Match& match) {
    passed_s_ = match.reference ? evidence.frame().timestamp_s - match.reference->timestamp_s : 0;
    if (!(passed_s_ > 0)) passed_s_ = kUnknown_s;
    for (double& age_s : ages_s_) age_s += passed_s_;
    ages_s_.insert(ages_s_.begin(), 0);
    ages_s_.resize(std::min(ages_s_.size(), static_cast<std::size_t>(kMostFrames) + 1));
    steps_.insert(steps_.begin(), evidence.motion_prior(match));
    steps_.resize(ages_s_.size() - 1);
  }
  double passed_s() const { return passed_s_; }
  double gap_s(int gap) const { return ages_s_[static_cast<std::size_t>(gap)]; }

  /// The longest gap that most tracks cover, its half, its quarter and so on, and a gap for the ground.
  void choose(const FeatureTracks& tracks, double max_gap_s, bool ground, Gaps& gaps) {
    count(tracks);
    gaps.all.clear();
    gaps.ground = 0;
    if (ages_s_.size() < 2 || counts_[1] == 0) return;
    const auto within = [&](int gap, double limit_s) {
      return gap < static_cast<int>(ages_s_.size()) && gap_s(gap) <= limit_s * (1 + 1e-6);
    };
    int longest = 1;
    while (within(longest + 1, max_gap_s) &&
           counts_[static_cast<std::size_t>(longest) + 1] >= kMostTracks * counts_[1])
      ++longest;
    for (int gap = longest; gap > 0; gap /= 2) gaps.all.push_back(gap);
    if (!ground) return;
    gaps.ground = 1;
    while (gaps.ground < longest && within(gaps.ground + 1, kGroundGap_s)) ++gaps.ground;
    gaps.all.push_back(gaps.ground);
    std::sort(gaps.all.rbegin(), gaps.all.rend());
    gaps.all.erase(std::unique(gaps.all.begin(), gaps.all.end()), gaps.all.end());
  }
  /// Of the camera over a gap, if every step has a prior.
  std::optional<ViewTurn> turn_over(int gap) const {
    Eigen::Matrix3d R = Eigen::Matrix3d::Identity();  // R_current_reference
    double sigma_rad = 0;  // a bias is the same in every step, so deviations add up
    for (std::size_t k = 0; k < static_cast<std::size_t>(gap); ++k) {
      if (k >= steps_.size() || !steps_[k]) return std::nullopt;
      R = R * steps_[k]->T_current_reference.R();
      sigma_rad += std::sqrt(steps_[k]->covariance_matrix().bottomRightCorner<3, 3>().trace() / 3);
    }
    const Eigen::Vector3d back = rotation_vector(R.transpose());
    return ViewTurn{{back.x(), back.y(), back.z()}, sigma_rad};
  }

 private:
  static constexpr double kUnknown_s = 1.0 / 30;  ///< between frames whose timestamps do not increase
  static constexpr double kMostTracks = 0.7;      ///< share of the tracks that cover the longest gap
  static constexpr double kGroundGap_s = 0.2;     ///< short, because near ground soon leaves the view

  void count(const FeatureTracks& tracks) {
    counts_.assign(ages_s_.size() + 1, 0);
    for (std::size_t i = 0; i < tracks.size(); ++i)
      for (int k = 1; k <= tracks.length(i) && k < static_cast<int>(ages_s_.size()); ++k)
        ++counts_[static_cast<std::size_t>(k)];
  }

  std::vector<double> ages_s_;                     ///< age of each recent frame
  std::vector<std::optional<MotionPrior>> steps_;  ///< newest first
  double passed_s_ = 0;
  std::vector<int> counts_;  ///< of the tracks, by length
};

}  // namespace dynfilter::detail
