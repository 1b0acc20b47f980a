// SPDX-License-Identifier: MIT
// The ten filters of docs/tutorials/write_a_filter.md.
// The page shows some of the parts between "recipe" and "end" word for word, and names all.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <dynfilter/config/parameters.hpp>
#include <dynfilter/core/filter.hpp>
#include <dynfilter/core/point_grid.hpp>
#include <dynfilter/evidence/evidence.hpp>
#include <dynfilter/geometry/depth_noise.hpp>
#include <dynfilter/geometry/rigid_motion.hpp>
#include <dynfilter/geometry/two_view.hpp>
#include <optional>
#include <string>
#include <vector>

namespace recipes {

using dynfilter::Evidence;
using dynfilter::Filter;
using dynfilter::Input;
using dynfilter::Match;
using dynfilter::NamedFilter;
using dynfilter::Needs;
using dynfilter::suspicion;
using dynfilter::Vote;
using dynfilter::Votes;

// recipe 1
struct TooNearParams {
  double min_depth_m = 0.4;

  static const dynfilter::FieldTable<TooNearParams>& fields() {
    static const dynfilter::FieldTable<TooNearParams> table{
        dynfilter::real("min_depth_m", &TooNearParams::min_depth_m, "m", {0, 100},
                        "features nearer than this are dynamic"),
    };
    return table;
  }
};

class TooNear final : public NamedFilter<TooNear> {
 public:
  using Params = TooNearParams;
  static constexpr const char* kName = "too_near";
  static constexpr const char* kSummary = "features on the robot's own arm";

  explicit TooNear(Params params = Params()) : params_(params) {
    dynfilter::check_parameters(params_, kName);
  }
  Needs needs() const override { return {Input::Depth, Input::None, 0}; }

  void apply(const Evidence& evidence, Votes& votes) override {
    for (std::size_t i = 0; i < evidence.size(); ++i) {
      const float depth_m = evidence.depths_m()[i];
      if (std::isnan(depth_m)) continue;  // no depth: Unknown
      votes.cast(i, depth_m < params_.min_depth_m ? Vote::Dynamic : Vote::Static);
    }
  }

 private:
  Params params_;
};
// end

// recipe 2
class BoxSuspects final : public Filter {
 public:
  std::string name() const override { return "box_suspects"; }
  Needs needs() const override { return {Input::Detections, Input::None, 0}; }

  void apply(const Evidence& evidence, Votes& votes) override {
    for (const dynfilter::Detection& d : evidence.frame().detections->detections)
      for (std::size_t i = 0; i < evidence.size(); ++i)
        if (d.class_name == "person" && d.box.contains(evidence.pixels()[i]))
          votes.mark_prior(i);
  }
};
// end

// recipe 3
class OffTheLine final : public Filter {
 public:
  std::string name() const override { return "off_the_line"; }
  Needs needs() const override { return {Input::Correspondence, Input::Camera, 1}; }

  void apply(const Evidence& evidence, Votes& votes) override {
    const Match& match = evidence.match({});  // with the last frame
    evidence.collect_seeds(match, false, seeds_);
    const dynfilter::TwoViewModel& model = evidence.two_view(match, seeds_);
    votes.note(std::string("model: ") + to_string(model.kind));
    for (std::size_t i = 0; i < evidence.size(); ++i) {
      const double off_px = dynfilter::distance_px(
          model, match.reference_undistorted_px[i], evidence.undistorted_pixels()[i]);
      if (std::isnan(off_px)) continue;  // no match, or no model
      votes.cast(i, off_px > kMaxPx ? Vote::Dynamic : Vote::Static,
                 suspicion(off_px, kMaxPx));
    }
  }

 private:
  static constexpr double kMaxPx = 1.0;
  std::vector<int> seeds_;
};
// end

// recipe 4
class OffTheMotion final : public Filter {
 public:
  std::string name() const override { return "off_the_motion"; }
  Needs needs() const override {
    return {Input::Correspondence | Input::Depth | Input::Camera, Input::Pose, 1};
  }

  void apply(const Evidence& evidence, Votes& votes) override {
    const Match& match = evidence.match({});
    evidence.collect_seeds(match, false, seeds_);
    const dynfilter::RigidMotion& motion = evidence.rigid_motion(match, seeds_);
    if (!motion.ok) return votes.note(to_string(motion.note));
    for (std::size_t i = 0; i < evidence.size(); ++i) {
      const cv::Point3f then = match.reference_points_m[i], now = evidence.points_m()[i];
      const Eigen::Vector3d p(then.x, then.y, then.z);
      const Eigen::Vector3d moved = motion.T_current_reference.isometry() * p;
      const double off_m = (Eigen::Vector3d(now.x, now.y, now.z) - moved).norm();
      if (std::isnan(off_m)) continue;  // no match, or no depth in one of the frames
      const double limit_m = 0.01 + 4 * noise_.sigma_m(now.z);
      votes.cast(i, off_m > limit_m ? Vote::Dynamic : Vote::Static,
                 suspicion(off_m, limit_m));
    }
  }

 private:
  dynfilter::DepthNoise noise_;
  std::vector<int> seeds_;
};
// end

// recipe 5
class OffTheHostsPose final : public Filter {
 public:
  std::string name() const override { return "off_the_hosts_pose"; }
  Needs needs() const override {
    return {Input::Correspondence | Input::Depth | Input::Camera | Input::Pose,
            Input::None, 5};
  }

  void apply(const Evidence& evidence, Votes& votes) override {
    const Match& match = evidence.match({false, 5});  // detects slow movers
    const std::optional<dynfilter::Pose> T_now_then = evidence.host_motion(match);
    if (!T_now_then) return votes.note("the host gave no pose of that frame");
    for (std::size_t i = 0; i < evidence.size(); ++i) {
      const cv::Point3f then = match.reference_points_m[i], now = evidence.points_m()[i];
      const Eigen::Vector3d moved =
          T_now_then->isometry() * Eigen::Vector3d(then.x, then.y, then.z);
      const double off_m = (Eigen::Vector3d(now.x, now.y, now.z) - moved).norm();
      if (std::isnan(off_m)) continue;
      const double limit_m = 0.02 + 3 * noise_.sigma_m(now.z);
      votes.cast(i, off_m > limit_m ? Vote::Dynamic : Vote::Static,
                 suspicion(off_m, limit_m));
    }
  }

 private:
  dynfilter::DepthNoise noise_;
};
// end

// recipe 6
class UnlikeMatches final : public Filter {
 public:
  std::string name() const override { return "unlike_matches"; }
  Needs needs() const override {
    return {Input::Correspondence | Input::Descriptors, Input::None, 1};
  }

  void apply(const Evidence& evidence, Votes& votes) override {
    const dynfilter::MatchedFeatures& matched =
        evidence.matched_features(evidence.match({}));
    for (std::size_t i = 0; i < evidence.size(); ++i) {
      const int bits = matched.distance_bits(i);
      if (bits < 0) continue;  // no match, or no descriptors
      votes.cast(i, bits > kMaxBits ? Vote::Dynamic : Vote::Static,
                 suspicion(bits, kMaxBits));
    }
  }

 private:
  static constexpr int kMaxBits = 64;
};
// end

// recipe 7
class SharedMatches final : public Filter {
 public:
  std::string name() const override { return "shared_matches"; }
  Needs needs() const override { return {Input::Correspondence, Input::None, 1}; }

  void apply(const Evidence& evidence, Votes& votes) override {
    const Match& match = evidence.match({});
    if (match.reference == nullptr) return votes.note("no earlier frame");
    const dynfilter::MatchedFeatures& matched = evidence.matched_features(match);
    users_.assign(match.reference->keypoints.size(), 0);
    for (std::size_t i = 0; i < evidence.size(); ++i)
      if (matched.index(i) >= 0) ++users_[static_cast<std::size_t>(matched.index(i))];
    for (std::size_t i = 0; i < evidence.size(); ++i) {
      if (matched.index(i) < 0) continue;
      const bool shared = users_[static_cast<std::size_t>(matched.index(i))] > 1;
      votes.cast(i, shared ? Vote::Dynamic : Vote::Static);
    }
  }

 private:
  std::vector<int> users_;  // of each feature of the last frame
};
// end

// recipe 8
class AgainstTheKeyframe final : public Filter {
 public:
  std::string name() const override { return "against_the_keyframe"; }
  Needs needs() const override { return {Input::Correspondence, Input::Camera, 1}; }

  void apply(const Evidence& evidence, Votes& votes) override {
    const Match& match = evidence.match({true, 1});  // with the last keyframe
    if (match.reference == nullptr) return votes.note("no keyframe yet");
    evidence.collect_seeds(match, false, seeds_);
    const dynfilter::TwoViewModel& model = evidence.two_view(match, seeds_);
    for (std::size_t i = 0; i < evidence.size(); ++i) {
      const auto verdict = dynfilter::judge(model, match.reference_undistorted_px[i],
                                            evidence.undistorted_pixels()[i], 2.0);
      if (verdict == dynfilter::TwoViewVerdict::Inconsistent)
        votes.cast(i, Vote::Dynamic);
      if (verdict == dynfilter::TwoViewVerdict::Consistent) votes.cast(i, Vote::Static);
    }
  }

 private:
  std::vector<int> seeds_;
};
// end

// recipe 9
class SpreadToNeighbours final : public Filter {
 public:
  std::string name() const override { return "spread_to_neighbours"; }
  Needs needs() const override { return {Input::None, Input::None, 0}; }

  void apply(const Evidence& evidence, Votes& votes) override {
    grid_.build(dynfilter::Span<const cv::Point2f>(evidence.pixels()), kRadiusPx);
    for (std::size_t i = 0; i < evidence.size(); ++i) {
      if (!evidence.judged(i)) continue;  // an earlier stage rejected it
      int all = 0, dynamic = 0;
      grid_.around(evidence.pixels()[i], kRadiusPx, [&](std::int32_t j) {
        const auto k = static_cast<std::size_t>(j);
        if (k == i || cv::norm(evidence.pixels()[k] - evidence.pixels()[i]) > kRadiusPx)
          return;
        ++all;
        dynamic += evidence.called_dynamic(k) ? 1 : 0;
      });
      if (all >= 3 && 2 * dynamic > all) votes.cast(i, Vote::Dynamic);
    }
  }

 private:
  static constexpr float kRadiusPx = 40;
  dynfilter::PointGrid grid_;
};
// end

// recipe 10
class RejectedBefore final : public Filter {
 public:
  std::string name() const override { return "rejected_before"; }
  Needs needs() const override { return {Input::Correspondence, Input::None, 1}; }

  void apply(const Evidence& evidence, Votes& votes) override {
    const dynfilter::MatchedFeatures& matched =
        evidence.matched_features(evidence.match({}));
    now_.assign(evidence.size(), 0);
    for (std::size_t i = 0; i < evidence.size(); ++i) {
      const std::int32_t j = matched.index(i);
      const bool known = j >= 0 && static_cast<std::size_t>(j) < memory_.size();
      const float before = known ? memory_[static_cast<std::size_t>(j)] : 0;
      now_[i] = 0.8F * before + (evidence.called_dynamic(i) ? 0.2F : 0.0F);
      if (now_[i] > 0.4F) votes.cast(i, Vote::Dynamic, now_[i]);
    }
    memory_.swap(now_);
  }
  void reset() override { memory_.clear(); }

 private:
  std::vector<float> memory_, now_;  // how often each feature was rejected lately
};
// end

}  // namespace recipes
