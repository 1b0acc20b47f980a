// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <dynfilter/core/limits.hpp>
#include <dynfilter/core/portable_math.hpp>
#include <dynfilter/evidence/frame_evidence.hpp>
#include <dynfilter/pipeline/combinator.hpp>
#include <iterator>
#include <unordered_map>
#include <utility>
#include <vector>

namespace dynfilter {

struct TemporalParams {
  double reliability = 0.75;
  double memory = 0.8;
  double threshold = 0.5;  ///< Dynamic above this belief, static below. Not a key: code sets it.
  /// Frames without an observation after which a map point is forgotten.
  static constexpr int kForgetFrames = 300;

  static const FieldTable<TemporalParams>& fields() {
    using P = TemporalParams;
    static const FieldTable<P> table{
        real("reliability", &P::reliability, "", {0.5, 0.999}, "probability that the stage's vote is right"),
        real("memory", &P::memory, "", {0, 1},
             "share of the log-odds that is kept to the next frame; 1: no forgetting"),
    };
    return table;
  }
};

/// `temporal`: a belief per map point if the host provides them, else per track
/// (evidence/feature_tracks.hpp). The stage's votes update it with Bayes' rule:
///   log b/(1-b) <- memory * log b/(1-b) +- log r/(1-r).
/// The last term is added for dynamic, subtracted for static and omitted for unknown. r is the reliability.
/// A single wrong vote does not decide. A feature that the stage cannot judge is judged by its earlier votes.
/// A feature without a belief is unknown.
class TemporalStage final : public ParametricCombinator<TemporalStage, TemporalParams> {
 public:
  using ParametricCombinator::ParametricCombinator;
  static constexpr const char* kName = "temporal";
  static constexpr const char* kSummary = "a belief per track or map point, updated by the stage's votes";
  static constexpr const char* kDynamic = "if the belief is above the threshold";

  Needs needs() const override;
  void reset() override {
    Combinator::reset();
    points_.clear();
    odds_.clear();
  }

 protected:
  void decide(FrameEvidence& evidence, StageReports& reports, std::size_t self, Judgement& out) override;

 private:
  // So that later votes can still change any belief.
  static constexpr double kMostLogOdds = 8, kRounding = 1e-9;
  struct Point {
    double odds = 0;
    std::int64_t seen = 0;
  };

  void recall(FrameEvidence& evidence);
  void remember(const FrameEvidence& evidence);

  std::vector<double> odds_, last_odds_;
  std::unordered_map<std::int64_t, Point> points_;
};

inline Needs TemporalStage::needs() const {
  Needs all = Combinator::needs();
  all.optional = all.optional | Input::MapPoints | Input::Correspondence;
  all.history_frames = std::max(all.history_frames, 1);
  return all;
}

inline void TemporalStage::decide(FrameEvidence& evidence, StageReports& reports, std::size_t self,
                                  Judgement& out) {
  children_[0]->judge(evidence, reports, child_);
  out.votes.add_priors(child_.votes);
  recall(evidence);
  const double step = portable::log_odds(params_.reliability), limit = portable::log_odds(params_.threshold);
  for (std::size_t i = 0; i < evidence.size(); ++i) {
    const Vote said = child_.votes[i];
    odds_[i] += said == Vote::Dynamic ? step : said == Vote::Static ? -step : 0;
    odds_[i] = std::clamp(odds_[i], -kMostLogOdds, kMostLogOdds);
    if (odds_[i] == 0) continue;
    const Vote vote = odds_[i] > limit + kRounding   ? Vote::Dynamic
                      : odds_[i] < limit - kRounding ? Vote::Static
                                                     : Vote::Unknown;
    const auto belief = static_cast<float>(1 / (1 + portable::exp(-odds_[i])));
    set(out, i, vote, belief, said == Vote::Dynamic ? child_.reasons[i] : own_reason(self));
  }
  remember(evidence);
}

inline void TemporalStage::recall(FrameEvidence& evidence) {
  std::swap(odds_, last_odds_);
  odds_.assign(evidence.size(), 0);
  if (!evidence.frame().map_point_ids.empty()) {
    for (std::size_t i = 0; i < evidence.size(); ++i) {
      const auto known = points_.find(evidence.frame().map_point_ids[i]);
      if (known != points_.end()) odds_[i] = params_.memory * known->second.odds;
    }
    return;
  }
  const FeatureTracks& tracks = evidence.tracks(TrackOptions());
  for (std::size_t i = 0; i < evidence.size(); ++i) {
    const auto from = static_cast<std::size_t>(tracks.previous(i));
    if (tracks.previous(i) >= 0 && from < last_odds_.size()) odds_[i] = params_.memory * last_odds_[from];
  }
}

inline void TemporalStage::remember(const FrameEvidence& evidence) {
  const FrameView& frame = evidence.frame();
  for (std::size_t i = 0; i < frame.map_point_ids.size(); ++i)
    if (frame.map_point_ids[i] >= 0 && odds_[i] != 0) points_[frame.map_point_ids[i]] = {odds_[i], frame.id};
  if (frame.id % 32 != 0) return;
  for (auto it = points_.begin(); it != points_.end();)
    it = id_gap(frame.id, it->second.seen) > Params::kForgetFrames ? points_.erase(it) : std::next(it);
}

}  // namespace dynfilter
