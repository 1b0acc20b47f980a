// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/pipeline/stage.hpp>

#include <chrono>
#include <dynfilter/core/append_text.hpp>
#include <dynfilter/core/error.hpp>
#include <dynfilter/core/inline.hpp>
#include <dynfilter/core/span.hpp>
#include <exception>

namespace dynfilter {

DYNFILTER_INLINE void Stage::judge(FrameEvidence& evidence, StageReports& reports, Judgement& out) {
  const auto start = std::chrono::steady_clock::now();
  const std::size_t self = reports.size();
  reports.add(name_, path_);
  out.reset(evidence.size());
  run(evidence, reports, self, out);
  StageReport& report = reports[self];
  report.judged = evidence.count_judged();
  if (report.judged < evidence.size()) drop_unasked(evidence, out);
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

inline void Stage::fail(StageReport& report, const std::string& what, std::size_t n, Judgement& out) {
  report.failed = true;
  report.note = "failed: " + what;
  out.reset(n);
}

inline void Stage::drop_unasked(const FrameEvidence& evidence, Judgement& out) {
  const Span<const std::uint8_t> judged = evidence.judged();
  out.votes.keep_only(judged);
  for (std::size_t i = 0; i < judged.size(); ++i) out.reasons[i] = judged[i] != 0 ? out.reasons[i] : 0;
}

DYNFILTER_INLINE void join_notes(std::string& to, const std::string& first, const std::string& second) {
  to.clear();
  append_text(to, first, first.empty() || second.empty() ? "" : "; ", second);
}

DYNFILTER_INLINE Needs FilterStage::needs_of(const Filter& filter) {
  try {
    return filter.needs();
  } catch (const std::exception& error) {
    throw Error("filter `" + filter.name() + "`: its needs: " + error.what());
  } catch (...) {
    throw Error("filter `" + filter.name() + "`: its needs: an unknown exception");
  }
}

DYNFILTER_INLINE void FilterStage::reset() {
  reset_fault_.clear();
  try {
    filter_->reset();
  } catch (const std::exception& error) {
    reset_fault_ = error.what();
  } catch (...) {
    reset_fault_ = "an unknown exception";
  }
}

DYNFILTER_INLINE void FilterStage::decide(FrameEvidence& evidence, StageReports& reports, std::size_t self,
                                          Judgement& out) {
  if (evidence.stages().is_late()) {
    evidence.stages().skipped_late();
    reports[self].skipped = true;
    reports[self].note = "skipped: over the time budget";
    return;
  }
  if (!reset_fault_.empty()) throw Error("reset: " + reset_fault_);
  filter_->apply(evidence, out.votes);
  if (evidence.stages().is_late()) evidence.stages().ended_late(self);
  join_notes(reports[self].note, evidence.take_match_note(), out.votes.notes());
  if (out.votes.size() != evidence.size()) throw Error("the filter changed the number of votes");
  if (self >= 64) return;
  const std::uint64_t reason = std::uint64_t{1} << self;
  for (std::size_t i = 0; i < evidence.size(); ++i)
    out.reasons[i] = out.votes[i] == Vote::Dynamic ? reason : 0;
  if (evidence.stages().collects_suspicions() && is_semantic()) tell_suspicions(evidence, out.votes, reason);
}

inline void FilterStage::tell_suspicions(FrameEvidence& evidence, const Votes& votes, std::uint64_t reason) {
  for (std::size_t i = 0; i < evidence.size(); ++i)
    if (evidence.judged(i) && (votes.prior(i) || votes[i] == Vote::Dynamic))
      evidence.stages().suspect(i, reason);
}

}  // namespace dynfilter
