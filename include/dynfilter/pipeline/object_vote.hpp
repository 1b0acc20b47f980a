// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <dynfilter/core/needs.hpp>
#include <dynfilter/config/parameters.hpp>
#include <dynfilter/core/verdict.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/evidence/frame_evidence.hpp>
#include <dynfilter/pipeline/detail/object_regions.hpp>
#include <dynfilter/pipeline/combinator.hpp>
#include <dynfilter/pipeline/judgement.hpp>
#include <string>
#include <vector>

namespace dynfilter {

enum class OtherFeatures { Keep, Drop };

struct ObjectVoteParams {
  ObjectRegionParams region;
  int min_count = 2;
  double min_share = 0.5;
  OtherFeatures others = OtherFeatures::Keep;

  static const FieldTable<ObjectVoteParams>& fields();
};

/// `object_vote`: decides for whole objects.
/// An object is a box, an instance mask, a mask or one of its connected components.
/// The stage's votes on and near an object decide for all its features (vote_object()).
/// A feature of several objects is dynamic if one of them is.
/// `others` sets the vote of features of no object, and of objects that cannot be judged.
class ObjectVoteStage final : public Combinator {
 public:
  using Params = ObjectVoteParams;
  static constexpr const char* kName = "object_vote";
  static constexpr const char* kSummary = "the stage's votes on an object decide for all its features";
  static constexpr const char* kDynamic =
      "if its object is: at least `min_count` votes, of which `min_share` are dynamic";

  ObjectVoteStage(std::string path, Stages children, Params params = Params());

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

  Params params_;
  ObjectRegions regions_;
  Votes found_;  ///< only its notes are used
  std::vector<Vote> verdict_;
  std::vector<float> share_;
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/pipeline/detail/object_vote-inl.hpp>
#endif
