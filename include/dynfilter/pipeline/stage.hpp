// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cstdint>
#include <dynfilter/context/context.hpp>
#include <dynfilter/core/filter.hpp>
#include <dynfilter/core/verdict.hpp>
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

  void judge(Context& context, std::vector<StageReport>& reports, Judgement& out) {
    const auto start = std::chrono::steady_clock::now();
    const std::size_t self = reports.size();
    reports.emplace_back();
    reports[self].name = name_;
    reports[self].path = path_;
    out.reset(context.size());
    run(context, reports, self, out);
    StageReport& report = reports[self];
    report.judged = context.count_judged();
    if (report.judged < context.size()) drop_unasked(context, out);
    report.dynamic = out.votes.count(Vote::Dynamic);
    report.unknown = out.votes.count(Vote::Unknown) - (out.votes.size() - report.judged);
    report.prior = out.votes.count_prior();
    report.time_ms =
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  }

 protected:
  /// Fills `out`, which is all Unknown on entry. `self` is the index of this node in `reports`.
  virtual void decide(Context& context, std::vector<StageReport>& reports, std::size_t self,
                      Judgement& out) = 0;

 private:
  void run(Context& context, std::vector<StageReport>& reports, std::size_t self, Judgement& out) {
    const Input missing = without(needs().required, context.inputs());
    if (missing != Input::None) {
      reports[self].skipped = true;
      reports[self].note = "skipped: no " + to_string(missing);
      return;
    }
    try {
      decide(context, reports, self, out);
    } catch (const std::exception& error) {
      fail(reports[self], error.what(), context.size(), out);
    } catch (...) {
      fail(reports[self], "an unknown exception", context.size(), out);
    }
  }
  static void fail(StageReport& report, const std::string& what, std::size_t n, Judgement& out) {
    report.failed = true;
    report.note = "failed: " + what;
    out.reset(n);
  }
  static void drop_unasked(const Context& context, Judgement& out) {
    const Span<const std::uint8_t> judged = context.judged();
    out.votes.keep_only(judged);
    for (std::size_t i = 0; i < judged.size(); ++i) out.reasons[i] = judged[i] != 0 ? out.reasons[i] : 0;
  }

  std::string name_, path_;
};

/// A leaf: one filter.
class FilterStage final : public Stage {
 public:
  FilterStage(std::unique_ptr<Filter> filter, std::string path)
      : Stage(filter->name(), std::move(path)), filter_(std::move(filter)) {}

  Needs needs() const override { return filter_->needs(); }
  void reset() override { filter_->reset(); }
  const Filter& filter() const { return *filter_; }

 protected:
  void decide(Context& context, std::vector<StageReport>& reports, std::size_t self,
              Judgement& out) override {
    context.take_note();
    filter_->apply(context, out.votes);
    reports[self].note = context.take_note();
    if (out.votes.size() != context.size()) throw Error("the filter changed the number of votes");
    if (self >= 64) return;
    const std::uint64_t reason = std::uint64_t{1} << self;
    for (std::size_t i = 0; i < context.size(); ++i)
      out.reasons[i] = out.votes[i] == Vote::Dynamic ? reason : 0;
    if (context.collects_suspicions() && is_semantic()) tell_suspicions(context, out.votes, reason);
  }

 private:
  bool is_semantic() const {
    return (filter_->needs().required & (Input::Detections | Input::Mask)) != Input::None;
  }
  static void tell_suspicions(Context& context, const Votes& votes, std::uint64_t reason) {
    for (std::size_t i = 0; i < context.size(); ++i)
      if (context.judged(i) && (votes.prior(i) || votes[i] == Vote::Dynamic)) context.suspect(i, reason);
  }

  std::unique_ptr<Filter> filter_;
};

}  // namespace dynfilter
