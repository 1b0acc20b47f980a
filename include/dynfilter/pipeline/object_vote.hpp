// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <dynfilter/core/printable_text.hpp>
#include <dynfilter/evidence/frame_evidence.hpp>
#include <dynfilter/evidence/semantic_input.hpp>
#include <dynfilter/pipeline/combinator.hpp>
#include <dynfilter/pipeline/detail/object_regions.hpp>
#include <vector>

namespace dynfilter {

/// What becomes of features on no object.
enum class OtherFeatures { Keep, Drop };

struct ObjectVoteParams {
  ObjectRegionParams region;
  int min_count = 2;
  double min_share = 0.5;
  OtherFeatures others = OtherFeatures::Keep;

  static const FieldTable<ObjectVoteParams>& fields() {
    using P = ObjectVoteParams;
    static const FieldTable<P> table = [] {
      FieldTable<P> all;
      include_fields(all, &P::region);
      all.push_back(integer("min_count", &P::min_count, "features", {1, 100000},
                            "smallest number of votes that judge an object"));
      all.push_back(
          real("min_share", &P::min_share, "", {0, 1},
               "smallest share of dynamic votes, unknown ones excluded, that makes an object dynamic"));
      all.push_back(
          choice("others", &P::others, {{"keep", OtherFeatures::Keep}, {"drop", OtherFeatures::Drop}},
                 "for features of no object, keep uses the stage's vote and drop makes it unknown"));
      return all;
    }();
    return table;
  }
};

/// `object_vote`: decides for whole objects. An object is a box, an instance mask, a mask or one of its
/// connected components. The stage's votes on and near an object decide for all its features (vote_object()).
/// A feature of several objects is dynamic if one of them is. `others` sets the vote of features of no
/// object, and of objects that cannot be judged.
class ObjectVoteStage final : public ParametricCombinator<ObjectVoteStage, ObjectVoteParams> {
 public:
  using ParametricCombinator::ParametricCombinator;
  static constexpr const char* kName = "object_vote";
  static constexpr const char* kSummary = "the stage's votes on an object decide for all its features";
  static constexpr const char* kDynamic =
      "if its object is: at least `min_count` votes, of which `min_share` are dynamic";

  Needs needs() const override;

 protected:
  void decide(FrameEvidence& evidence, StageReports& reports, std::size_t self, Judgement& out) override;

 private:
  struct Judge final : ObjectVisitor {
    Judge(ObjectVoteStage& its_stage, const Votes& its_votes) : stage(its_stage), votes(its_votes) {}
    void visit(const ObjectRegion& object) override {
      ++objects;
      moving += stage.judge(object, votes) ? 1 : 0;
    }
    ObjectVoteStage& stage;
    const Votes& votes;
    std::size_t objects = 0;
    int moving = 0;
  };

  bool judge(const ObjectRegion& object, const Votes& votes);
  void follow(std::size_t i, std::uint64_t reason, Judgement& out) const;

  ObjectRegions regions_;
  Votes found_;  ///< only its notes are used
  std::vector<Vote> verdict_;
  std::vector<float> share_;
};

inline Needs ObjectVoteStage::needs() const {
  Needs all = Combinator::needs();
  all.optional = all.optional | ObjectRegions::input(params_.region) | Input::Depth | Input::Correspondence;
  all.history_frames =
      std::max(all.history_frames, LateResult::history_frames(ObjectRegionParams::kMaxAgeFrames));
  return all;
}

inline void ObjectVoteStage::decide(FrameEvidence& evidence, StageReports& reports, std::size_t self,
                                    Judgement& out) {
  children_[0]->judge(evidence, reports, out);
  found_.reset(0);
  verdict_.assign(evidence.size(), Vote::Unknown);
  share_.assign(evidence.size(), 0);
  Judge judge(*this, out.votes);
  regions_.find(evidence, params_.region, found_, judge);
  join_notes(reports[self].note, evidence.take_match_note(), found_.notes());
  if (judge.objects > 0)
    append_text(reports[self].note, reports[self].note.empty() ? "" : "; ", judge.moving, " of ",
                judge.objects, " objects move");
  for (std::size_t i = 0; i < evidence.size(); ++i) follow(i, own_reason(self), out);
}

inline bool ObjectVoteStage::judge(const ObjectRegion& object, const Votes& votes) {
  int dynamic = 0, fixed = 0;
  for (const std::size_t i : object.near) {
    dynamic += votes[i] == Vote::Dynamic ? 1 : 0;
    fixed += votes[i] == Vote::Static ? 1 : 0;
  }
  const Vote vote = vote_object(dynamic, fixed, params_.min_count, params_.min_share);
  const float share =
      dynamic + fixed > 0 ? static_cast<float>(dynamic) / static_cast<float>(dynamic + fixed) : 0;
  if (vote == Vote::Unknown) return false;
  for (const std::size_t i : object.inside) {
    if (verdict_[i] != Vote::Dynamic) verdict_[i] = vote;
    share_[i] = std::max(share_[i], share);
  }
  return vote == Vote::Dynamic;
}

inline void ObjectVoteStage::follow(std::size_t i, std::uint64_t reason, Judgement& out) const {
  if (verdict_[i] == Vote::Dynamic)
    set(out, i, Vote::Dynamic, 0.5F + 0.5F * share_[i], out.reasons[i] | reason);
  else if (verdict_[i] == Vote::Static)
    set(out, i, Vote::Static, 0.5F * share_[i], 0);
  else if (params_.others == OtherFeatures::Drop)
    set(out, i, Vote::Unknown, Votes::kNoIdea, 0);
}

}  // namespace dynfilter
