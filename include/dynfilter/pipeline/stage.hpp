// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <dynfilter/core/error.hpp>
#include <dynfilter/core/filter.hpp>
#include <dynfilter/core/needs.hpp>
#include <dynfilter/core/span.hpp>
#include <dynfilter/core/verdict.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/evidence/frame_evidence.hpp>
#include <dynfilter/pipeline/judgement.hpp>
#include <exception>
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

  void judge(FrameEvidence& evidence, std::vector<StageReport>& reports, Judgement& out) {
    const auto start = std::chrono::steady_clock::now();
    const std::size_t self = reports.size();
    reports.emplace_back();
    reports[self].name = name_;
    reports[self].path = path_;
    out.reset(evidence.size());
    run(evidence, reports, self, out);
    StageReport& report = reports[self];
    report.judged = evidence.stages().count_judged();
    if (report.judged < evidence.size()) drop_unasked(evidence, out);
    report.dynamic = out.votes.count(Vote::Dynamic);
    report.unknown = out.votes.count(Vote::Unknown) - (out.votes.size() - report.judged);
    report.prior = out.votes.count_prior();
    report.time_ms =
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  }

 protected:
  /// Fills `out`, which is all Unknown on entry. `self` is the index of this node in `reports`.
  virtual void decide(FrameEvidence& evidence, std::vector<StageReport>& reports, std::size_t self,
                      Judgement& out) = 0;

 private:
  void run(FrameEvidence& evidence, std::vector<StageReport>& reports, std::size_t self, Judgement& out) {
    const Input missing = without(needs().required, evidence.inputs());
    if (missing != Input::None) {
      reports[self].skipped = true;
      reports[self].note = "skipped: no " + to_string(missing);
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
  static void fail(StageReport& report, const std::string& what, std::size_t n, Judgement& out) {
    report.failed = true;
    report.note = "failed: " + what;
    out.reset(n);
  }
  static void drop_unasked(const FrameEvidence& evidence, Judgement& out) {
    const Span<const std::uint8_t> judged = evidence.judged();
    out.votes.keep_only(judged);
    for (std::size_t i = 0; i < judged.size(); ++i) out.reasons[i] = judged[i] != 0 ? out.reasons[i] : 0;
  }

  std::string name_, path_;
};

inline std::string joined_notes(const std::string& first, const std::string& second) {
  return first + (first.empty() || second.empty() ? "" : "; ") + second;
}

/// A leaf: one filter.
class FilterStage final : public Stage {
 public:
  FilterStage(std::unique_ptr<Filter> filter, std::string path)
      : Stage(filter->name(), std::move(path)), filter_(std::move(filter)) {}

  Needs needs() const override { return filter_->needs(); }
  void reset() override { filter_->reset(); }
  const Filter& filter() const { return *filter_; }

 protected:
  void decide(FrameEvidence& evidence, std::vector<StageReport>& reports, std::size_t self,
              Judgement& out) override {
    filter_->apply(evidence, out.votes);
    reports[self].note = joined_notes(evidence.take_match_note(), out.votes.notes());
    if (out.votes.size() != evidence.size()) throw Error("the filter changed the number of votes");
    if (self >= 64) return;
    const std::uint64_t reason = std::uint64_t{1} << self;
    for (std::size_t i = 0; i < evidence.size(); ++i)
      out.reasons[i] = out.votes[i] == Vote::Dynamic ? reason : 0;
    if (evidence.stages().collects_suspicions() && is_semantic())
      tell_suspicions(evidence, out.votes, reason);
  }

 private:
  bool is_semantic() const {
    return (filter_->needs().required & (Input::Detections | Input::Mask)) != Input::None;
  }
  static void tell_suspicions(FrameEvidence& evidence, const Votes& votes, std::uint64_t reason) {
    for (std::size_t i = 0; i < evidence.size(); ++i)
      if (evidence.judged(i) && (votes.prior(i) || votes[i] == Vote::Dynamic))
        evidence.stages().suspect(i, reason);
  }

  std::unique_ptr<Filter> filter_;
};

}  // namespace dynfilter
