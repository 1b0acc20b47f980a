// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <dynfilter/core/filter.hpp>
#include <dynfilter/core/needs.hpp>
#include <dynfilter/core/verdict.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/evidence/frame_evidence.hpp>
#include <dynfilter/pipeline/judgement.hpp>
#include <dynfilter/pipeline/stage_reports.hpp>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace dynfilter {

/// A node of a pipeline: a filter, or a combinator of nodes.
/// judge() implements what all nodes share.
/// It skips a stage without its inputs, catches exceptions and measures time.
/// It counts votes, and it restricts them to the features that the stage may judge.
class Stage {
 public:
  Stage(std::string name, std::string path) : name_(std::move(name)), path_(std::move(path)) {}
  Stage(const Stage&) = delete;
  Stage& operator=(const Stage&) = delete;
  virtual ~Stage() = default;

  const std::string& name() const { return name_; }
  const std::string& path() const { return path_; }
  virtual Needs needs() const = 0;
  virtual void reset() = 0;
  /// Calls `visit` on this node and all nodes below, in file order.
  virtual void for_each(const std::function<void(const Stage&, int depth)>& visit, int depth = 0) const {
    visit(*this, depth);
  }

  void judge(FrameEvidence& evidence, StageReports& reports, Judgement& out);

 protected:
  /// Fills `out`, which is all Unknown on entry. `self` is the index of this node in `reports`.
  virtual void decide(FrameEvidence& evidence, StageReports& reports, std::size_t self, Judgement& out) = 0;

 private:
  void run(FrameEvidence& evidence, StageReports& reports, std::size_t self, Judgement& out);
  static void fail(StageReport& report, const std::string& what, std::size_t n, Judgement& out);
  static void drop_unasked(const FrameEvidence& evidence, Judgement& out);

  std::string name_, path_;
};

/// `to` = "first; second", or the one that is not empty.
void join_notes(std::string& to, const std::string& first, const std::string& second);

/// A leaf: one filter.
class FilterStage final : public Stage {
 public:
  /// Throws Error with the filter's name if it cannot say what it needs.
  FilterStage(std::unique_ptr<Filter> filter, std::string path)
      : Stage(filter->name(), std::move(path)), needs_(needs_of(*filter)), filter_(std::move(filter)) {}

  Needs needs() const override { return needs_; }
  /// An exception of the filter is reported with the next frames, until a reset succeeds.
  void reset() override;
  const Filter& filter() const { return *filter_; }

 protected:
  void decide(FrameEvidence& evidence, StageReports& reports, std::size_t self, Judgement& out) override;

 private:
  static Needs needs_of(const Filter& filter);
  bool is_semantic() const { return (needs_.required & (Input::Detections | Input::Mask)) != Input::None; }
  static void tell_suspicions(FrameEvidence& evidence, const Votes& votes, std::uint64_t reason);

  Needs needs_;  ///< a filter says it once
  std::unique_ptr<Filter> filter_;
  std::string reset_fault_;  ///< what the last reset threw
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/pipeline/detail/stage-inl.hpp>
#endif
