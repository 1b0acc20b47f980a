// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <dynfilter/core/error.hpp>
#include <dynfilter/evidence/frame_evidence.hpp>
#include <dynfilter/pipeline/combinator.hpp>
#include <string>
#include <utility>
#include <vector>

namespace dynfilter {

struct VoteParams {
  double min_votes = 0;
  double min_share = 0.5;
  std::vector<double> weights;

  static const FieldTable<VoteParams>& fields() {
    using P = VoteParams;
    static const FieldTable<P> table{
        real("min_votes", &P::min_votes, "votes", {0, 1e6},
             "smallest weight of dynamic votes; 0: use min_share"),
        real("min_share", &P::min_share, "", {0, 1},
             "smallest share of dynamic weight among participating members, if min_votes is 0"),
        reals("weights", &P::weights, "votes", {0, 1e6}, "one weight per member; empty: 1 each"),
    };
    return table;
  }
};

/// `vote`: dynamic if enough members vote dynamic, counted or weighted (vote_count()). For 1 of n it equals
/// `any`. For n of n it corresponds to `all`, but members do not know each other's votes. A skipped or failed
/// member is excluded from a share. If votes are counted, it counts as unknown.
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

inline VoteStage::VoteStage(std::string path, Stages children, Params params)
    : Combinator(kName, std::move(path), std::move(children)), params_(std::move(params)) {
  check_parameters(params_, this->path());
  if (params_.weights.empty()) params_.weights.assign(children_.size(), 1.0);
  if (params_.weights.size() != children_.size())
    throw ConfigError(this->path() + ".weights", "expected one per member, got " +
                                                     std::to_string(params_.weights.size()) + " for " +
                                                     std::to_string(children_.size()));
}

inline void VoteStage::decide(FrameEvidence& evidence, StageReports& reports, std::size_t, Judgement& out) {
  const std::size_t n = evidence.size();
  dynamic_.assign(n, 0);
  unknown_.assign(n, 0);
  suspicion_.assign(n, 0);
  double taking_part = 0;
  for (std::size_t k = 0; k < children_.size(); ++k) {
    const std::size_t place = reports.size();
    children_[k]->judge(evidence, reports, child_);
    out.votes.add_priors(child_.votes);
    const bool absent = reports[place].skipped || reports[place].failed;
    if (absent && params_.min_votes <= 0) continue;
    taking_part += params_.weights[k];
    count(params_.weights[k], out);
  }
  const double needed = params_.min_votes > 0 ? params_.min_votes : params_.min_share * taking_part;
  for (std::size_t i = 0; i < n && taking_part > 0; ++i)
    set(out, i, vote_count(dynamic_[i], unknown_[i], needed), static_cast<float>(suspicion_[i] / taking_part),
        out.reasons[i]);
}

inline void VoteStage::count(double weight, Judgement& out) {
  for (std::size_t i = 0; i < dynamic_.size(); ++i) {
    const Vote said = child_.votes[i];
    if (said == Vote::Dynamic) dynamic_[i] += weight;
    if (said == Vote::Unknown) unknown_[i] += weight;
    suspicion_[i] += weight * static_cast<double>(child_.votes.suspicion(i));
    out.reasons[i] |= child_.reasons[i];
  }
}

}  // namespace dynfilter
