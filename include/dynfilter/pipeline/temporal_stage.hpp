// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <dynfilter/core/needs.hpp>
#include <dynfilter/config/parameters.hpp>
#include <dynfilter/core/portable_math.hpp>
#include <dynfilter/core/verdict.hpp>
#include <dynfilter/evidence/frame_evidence.hpp>
#include <dynfilter/pipeline/combinator.hpp>
#include <dynfilter/pipeline/judgement.hpp>
#include <string>
#include <unordered_map>
#include <vector>

namespace dynfilter {

struct TemporalParams {
  double reliability = 0.75;
  double memory = 0.8;
  double threshold = 0.5;
  int forget_frames = 300;

  static const FieldTable<TemporalParams>& fields();
};

/// `temporal`: a belief per map point if the host provides them,
/// else per track (evidence/feature_tracks.hpp).
/// The stage's votes update it with Bayes' rule:
///   log b/(1-b) <- memory * log b/(1-b) +- log r/(1-r).
/// The last term is added for dynamic, subtracted for static and omitted for unknown.
/// r is the reliability.
/// A single wrong vote does not decide.
/// A feature that the stage cannot judge is judged by its earlier votes.
/// A feature without a belief is unknown.
class TemporalStage final : public Combinator {
 public:
  using Params = TemporalParams;
  static constexpr const char* kName = "temporal";
  static constexpr const char* kSummary = "a belief per track or map point, updated by the stage's votes";
  static constexpr const char* kDynamic = "if the belief is above the threshold";

  TemporalStage(std::string path, Stages children, Params params = Params());

  Needs needs() const override;
  void reset() override;

 protected:
  void decide(FrameEvidence& evidence, StageReports& reports, std::size_t self, Judgement& out) override;

 private:
  // So that later votes can still change any belief.
  static constexpr double kMostLogOdds = 8, kRounding = 1e-9;
  struct Point {
    double odds = 0;
    std::int64_t seen = 0;
  };
  static double log_odds(double p) { return portable::log(p / (1 - p)); }

  void recall(FrameEvidence& evidence);

  void remember(const FrameEvidence& evidence);

  Params params_;
  std::vector<double> odds_, last_odds_;
  std::unordered_map<std::int64_t, Point> points_;
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/pipeline/detail/temporal_stage-inl.hpp>
#endif
