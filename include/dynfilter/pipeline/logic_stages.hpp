// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <dynfilter/core/verdict.hpp>
#include <dynfilter/evidence/frame_evidence.hpp>
#include <dynfilter/pipeline/combinator.hpp>
#include <dynfilter/pipeline/judgement.hpp>
#include <string>
#include <utility>
#include <vector>

namespace dynfilter {

/// `sequence`: runs stages in order (vote_then()).
/// Each stage judges the features that earlier ones did not reject.
/// It fits its models without the features that they suspect.
class SequenceStage final : public Combinator {
 public:
  static constexpr const char* kName = "sequence";
  static constexpr const char* kSummary =
      "runs stages in order; each judges the survivors and fits models without suspects";
  static constexpr const char* kDynamic =
      "if one stage votes dynamic; later stages judge the survivors and fit without the suspects";
  SequenceStage(std::string path, Stages children)
      : Combinator(kName, std::move(path), std::move(children)) {}

 protected:
  void decide(FrameEvidence& evidence, StageReports& reports, std::size_t, Judgement& out) override;
};

/// `any`: dynamic if one member votes dynamic (vote_or()). Skipped or failed members do not count.
class AnyStage final : public Combinator {
 public:
  static constexpr const char* kName = "any";
  static constexpr const char* kSummary = "dynamic if one member votes dynamic";
  static constexpr const char* kDynamic = "if one member votes dynamic";
  AnyStage(std::string path, Stages children) : Combinator(kName, std::move(path), std::move(children)) {}

 protected:
  void decide(FrameEvidence& evidence, StageReports& reports, std::size_t, Judgement& out) override;
};

/// `all`: dynamic if every member votes dynamic (vote_and()).
/// Later members judge only features that no earlier member voted static.
/// They fit their models without the features that an earlier member voted dynamic.
/// If a member is skipped or fails, all features that are not static are unknown.
class AllStage final : public Combinator {
 public:
  static constexpr const char* kName = "all";
  static constexpr const char* kSummary = "dynamic if every member votes dynamic";
  static constexpr const char* kDynamic =
      "if every member votes dynamic; later members judge only features that are not static yet";
  AllStage(std::string path, Stages children) : Combinator(kName, std::move(path), std::move(children)) {}

 protected:
  void decide(FrameEvidence& evidence, StageReports& reports, std::size_t, Judgement& out) override;
};

/// `not`: exchanges static and dynamic (vote_not()).
class NotStage final : public Combinator {
 public:
  static constexpr const char* kName = "not";
  static constexpr const char* kSummary = "exchanges static and dynamic";
  static constexpr const char* kDynamic = "if the stage votes static";
  NotStage(std::string path, Stages children) : Combinator(kName, std::move(path), std::move(children)) {}

 protected:
  void decide(FrameEvidence& evidence, StageReports& reports, std::size_t self, Judgement& out) override;
};

/// `strict`: turns unknown into dynamic (vote_strict()).
/// Use it for suspects, which are then dynamic unless the stage votes static.
/// Unknown means, for example, that flow failed or that there is no earlier frame.
class StrictStage final : public Combinator {
 public:
  static constexpr const char* kName = "strict";
  static constexpr const char* kSummary =
      "unknown becomes dynamic: only features that the stage votes static are kept";
  static constexpr const char* kDynamic = "unless the stage votes static";
  StrictStage(std::string path, Stages children) : Combinator(kName, std::move(path), std::move(children)) {}

 protected:
  void decide(FrameEvidence& evidence, StageReports& reports, std::size_t self, Judgement& out) override;
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/pipeline/detail/logic_stages-inl.hpp>
#endif
