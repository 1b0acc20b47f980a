// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <dynfilter/config/parameters.hpp>
#include <dynfilter/core/verdict.hpp>
#include <dynfilter/evidence/frame_evidence.hpp>
#include <dynfilter/pipeline/combinator.hpp>
#include <dynfilter/pipeline/judgement.hpp>
#include <string>
#include <vector>

namespace dynfilter {

struct VoteParams {
  double min_votes = 0;
  double min_share = 0.5;
  std::vector<double> weights;

  static const FieldTable<VoteParams>& fields();
};

/// `vote`: dynamic if enough members vote dynamic, counted or weighted (vote_count()).
/// For 1 of n it equals `any`.
/// For n of n it corresponds to `all`, but members do not know each other's votes.
/// A skipped or failed member is excluded from a share.
/// If votes are counted, it counts as unknown.
class VoteStage final : public Combinator {
 public:
  using Params = VoteParams;
  static constexpr const char* kName = "vote";
  static constexpr const char* kSummary =
      "dynamic if enough members vote dynamic: k of n, a share, or weighted";
  static constexpr const char* kDynamic =
      "if the members that vote dynamic have enough weight; static if that is impossible";

  /// Throws ConfigError if weights are given, but not one per member.
  VoteStage(std::string path, Stages children, Params params = Params());

 protected:
  void decide(FrameEvidence& evidence, StageReports& reports, std::size_t, Judgement& out) override;

 private:
  void count(double weight, Judgement& out);

  Params params_;
  std::vector<double> dynamic_, unknown_, suspicion_;
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/pipeline/detail/vote_stage-inl.hpp>
#endif
