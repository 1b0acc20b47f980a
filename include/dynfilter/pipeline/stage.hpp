// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <dynfilter/core/error.hpp>
#include <dynfilter/core/filter.hpp>
#include <dynfilter/core/printable_text.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/evidence/frame_evidence.hpp>
#include <dynfilter/pipeline/judgement.hpp>
#include <exception>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace dynfilter {

/// The reports of one call of a pipeline, in the order of its file, and what its stages share beside votes:
/// the time that is left, and who suspects a feature. Reports of an earlier call give the memory of their
/// texts.
class StageReports {
 public:
  using Clock = std::chrono::steady_clock;

  /// `deadline`: the time after which no further filter starts; nullopt: never.
  StageReports(std::vector<StageReport>& list, std::optional<Clock::time_point> deadline)
      : list_(list), deadline_(deadline) {}

  /// An empty report. Its index is size() before the call.
  StageReport& add(const std::string& name, const std::string& path) {
    if (used_ == list_.size()) list_.emplace_back();
    StageReport& report = list_[used_++];
    report.name = name;
    report.path = path;
    report.note.clear();
    report.skipped = report.failed = report.doubted = false;
    report.judged = report.dynamic = report.unknown = report.prior = 0;
    report.time_ms = 0;
    return report;
  }
  std::size_t size() const { return used_; }
  StageReport& operator[](std::size_t k) { return list_[k]; }  ///< report k, in file order
  /// Removes what is left of the earlier call.
  void finish() { list_.resize(used_); }

  bool is_late() const { return deadline_ && Clock::now() > *deadline_; }  ///< whether the budget is used up
  /// Stage `k` ended late.
  void ended_late(std::size_t k) { late_at_ = late_at_.value_or(k); }
  void skipped_late() { ++late_skips_; }  ///< a stage was skipped because the budget is used up
  /// The first stage that ended late.
  std::optional<std::size_t> late_at() const { return late_at_; }
  std::size_t late_skips() const { return late_skips_; }  ///< how often

  /// From now on, notes which semantic stages suspect a feature, whatever becomes of it in the pipeline.
  void collect_suspicions(std::size_t features) { suspected_by_.emplace(features, 0); }
  /// Whether collect_suspicions() was called.
  bool collects_suspicions() const { return suspected_by_.has_value(); }
  /// Stages that suspect feature i; bit k: stage k.
  void suspect(std::size_t i, std::uint64_t stages) { (*suspected_by_)[i] |= stages; }
  /// Bit k: stage k. 0 unless they are collected.
  std::uint64_t suspected_by(std::size_t i) const { return suspected_by_ ? (*suspected_by_)[i] : 0; }

 private:
  std::vector<StageReport>& list_;
  std::size_t used_ = 0;
  std::optional<Clock::time_point> deadline_;
  std::optional<std::size_t> late_at_;
  std::size_t late_skips_ = 0;
  std::optional<std::vector<std::uint64_t>> suspected_by_;
};

/// A node of a pipeline: a filter, or a combinator of nodes. judge() implements what all nodes share.
/// It skips a stage without its inputs, catches exceptions and measures time.
/// It counts votes, and it restricts them to the features that the stage may judge.
class Stage {
 public:
  /// `path`: its place in the pipeline, for messages.
  Stage(std::string name, std::string path) : name_(std::move(name)), path_(std::move(path)) {}
  Stage(const Stage&) = delete;
  Stage& operator=(const Stage&) = delete;
  virtual ~Stage() = default;

  const std::string& name() const { return name_; }  ///< of the filter or combinator
  const std::string& path() const { return path_; }  ///< its place in the pipeline, for messages
  virtual Needs needs() const = 0;                   ///< inputs that it and all below it need
  virtual void reset() = 0;
  /// Calls `visit` on this node and all nodes below, in file order.
  virtual void for_each(const std::function<void(const Stage&, int depth)>& visit, int depth = 0) const {
    visit(*this, depth);
  }

  /// Fills `out`, one entry per feature, and adds reports.
  void judge(FrameEvidence& evidence, StageReports& reports, Judgement& out);

 protected:
  /// Fills `out`, which is all Unknown on entry. `self` is the index of this node in `reports`.
  virtual void decide(FrameEvidence& evidence, StageReports& reports, std::size_t self, Judgement& out) = 0;

 private:
  void run(FrameEvidence& evidence, StageReports& reports, std::size_t self, Judgement& out);
  static void fail(StageReport& report, const std::string& what, std::size_t n, Judgement& out) {
    report.failed = true;
    report.note = "failed: " + what;
    out.reset(n);
  }
  static void drop_not_judged(const FrameEvidence& evidence, Judgement& out) {
    const Span<const std::uint8_t> judged = evidence.judged();
    out.votes.keep_only(judged);
    for (std::size_t i = 0; i < judged.size(); ++i) out.reasons[i] = judged[i] != 0 ? out.reasons[i] : 0;
  }

  std::string name_, path_;
};

/// A leaf: one filter.
class FilterStage final : public Stage {
 public:
  /// Throws Error with the filter's name if it cannot say what it needs.
  FilterStage(std::unique_ptr<Filter> filter, std::string path)
      : Stage(filter->name(), std::move(path)), needs_(needs_of(*filter)), filter_(std::move(filter)) {}

  Needs needs() const override { return needs_; }
  /// An exception of the filter is reported with the next frames, until a reset succeeds.
  void reset() override;
  const Filter& filter() const { return *filter_; }  ///< that it calls

 protected:
  void decide(FrameEvidence& evidence, StageReports& reports, std::size_t self, Judgement& out) override;

 private:
  static Needs needs_of(const Filter& filter);
  bool is_semantic() const { return (needs_.required & (Input::Detections | Input::Mask)) != Input::None; }
  static void note_suspicions(const FrameEvidence& evidence, const Votes& votes, std::uint64_t reason,
                              StageReports& reports) {
    for (std::size_t i = 0; i < evidence.size(); ++i)
      if (evidence.judged(i) && (votes.prior(i) || votes[i] == Vote::Dynamic)) reports.suspect(i, reason);
  }

  Needs needs_;  ///< a filter says it once
  std::unique_ptr<Filter> filter_;
  std::string reset_fault_;  ///< what the last reset threw
};

inline void Stage::judge(FrameEvidence& evidence, StageReports& reports, Judgement& out) {
  const auto start = std::chrono::steady_clock::now();
  const std::size_t self = reports.size();
  reports.add(name_, path_);
  out.reset(evidence.size());
  run(evidence, reports, self, out);
  StageReport& report = reports[self];
  report.judged = evidence.count_judged();
  report.doubted = out.votes.doubts();
  if (report.judged < evidence.size()) drop_not_judged(evidence, out);
  report.dynamic = out.votes.count(Vote::Dynamic);
  report.unknown = out.votes.count(Vote::Unknown) - (out.votes.size() - report.judged);
  report.prior = out.votes.count_prior();
  report.time_ms =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

inline void Stage::run(FrameEvidence& evidence, StageReports& reports, std::size_t self, Judgement& out) {
  const Input missing = without(needs().required, evidence.inputs());
  if (missing != Input::None) {
    reports[self].skipped = true;
    append_text(reports[self].note, "skipped: no ");
    append_names(reports[self].note, missing);
    return;
  }
  try {
    decide(evidence, reports, self, out);
  } catch (const std::exception& error) {
    fail(reports[self], error.what(), evidence.size(), out);
  } catch (...) {
    fail(reports[self], "an unknown exception", evidence.size(), out);
  }
}

/// `to` = "first; second", or the one that is not empty.
inline void join_notes(std::string& to, const std::string& first, const std::string& second) {
  to.clear();
  append_text(to, first, first.empty() || second.empty() ? "" : "; ", second);
}

inline Needs FilterStage::needs_of(const Filter& filter) {
  try {
    return filter.needs();
  } catch (const std::exception& error) {
    throw Error("filter `" + filter.name() + "`: its needs: " + error.what());
  } catch (...) {
    throw Error("filter `" + filter.name() + "`: its needs: an unknown exception");
  }
}

inline void FilterStage::reset() {
  reset_fault_.clear();
  try {
    filter_->reset();
  } catch (const std::exception& error) {
    reset_fault_ = error.what();
  } catch (...) {
    reset_fault_ = "an unknown exception";
  }
}

inline void FilterStage::decide(FrameEvidence& evidence, StageReports& reports, std::size_t self,
                                Judgement& out) {
  if (reports.is_late()) {
    reports.skipped_late();
    reports[self].skipped = true;
    reports[self].note = "skipped: over the time budget";
    return;
  }
  if (!reset_fault_.empty()) throw Error("reset: " + reset_fault_);
  filter_->apply(evidence, out.votes);
  if (reports.is_late()) reports.ended_late(self);
  join_notes(reports[self].note, evidence.take_match_note(), out.votes.notes());
  if (out.votes.size() != evidence.size()) throw Error("the filter changed the number of votes");
  if (self >= 64) return;
  const std::uint64_t reason = std::uint64_t{1} << self;
  for (std::size_t i = 0; i < evidence.size(); ++i)
    out.reasons[i] = out.votes[i] == Vote::Dynamic ? reason : 0;
  if (reports.collects_suspicions() && is_semantic()) note_suspicions(evidence, out.votes, reason, reports);
}

}  // namespace dynfilter
