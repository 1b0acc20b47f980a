// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <dynfilter/core/verdict.hpp>
#include <string>
#include <vector>

namespace dynfilter {

/// The reports of one call of a pipeline, in the order of its file.
/// Reports of an earlier call give the memory of their texts.
class StageReports {
 public:
  explicit StageReports(std::vector<StageReport>& list) : list_(list) {}

  /// An empty report. Its index is size() before the call.
  StageReport& add(const std::string& name, const std::string& path) {
    if (used_ == list_.size()) list_.emplace_back();
    StageReport& report = list_[used_++];
    report.name = name;
    report.path = path;
    report.note.clear();
    report.skipped = report.failed = false;
    report.judged = report.dynamic = report.unknown = report.prior = 0;
    report.time_ms = 0;
    return report;
  }
  std::size_t size() const { return used_; }
  StageReport& operator[](std::size_t k) { return list_[k]; }
  /// Removes what is left of the earlier call.
  void finish() { list_.resize(used_); }

 private:
  std::vector<StageReport>& list_;
  std::size_t used_ = 0;
};

}  // namespace dynfilter
