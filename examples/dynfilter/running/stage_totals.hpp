// SPDX-License-Identifier: MIT
#pragma once

#include <fmt/format.h>
#include <dynfilter/core/verdict.hpp>

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <dynfilter/pipeline/pipeline.hpp>
#include <dynfilter/pipeline/stage.hpp>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "eval/statistics.hpp"
#include "text/json.hpp"
#include "text/table.hpp"

namespace dynfilter::command {

/// Counts and time of one stage over all frames of a run.
struct StageTotal {
  std::string call_point, name, path;
  int depth = 0;                                    ///< below the call point's first stage
  bool filter = false;                              ///< a rejector, not a combinator
  std::size_t frames = 0, skipped = 0, failed = 0;  ///< frames that reached the stage; of these, ...
  double judged = 0, dynamic = 0, unknown = 0, prior = 0, time_ms = 0;  ///< sums
  std::vector<float> times_ms;                                          ///< per frame, for the median
  std::map<std::string, std::size_t> notes;                             ///< note -> number of frames

  double mean(double sum) const { return frames > 0 ? sum / static_cast<double>(frames) : 0; }
  double median_ms() const { return times_ms.empty() ? 0 : eval::median({times_ms.begin(), times_ms.end()}); }
};

/// The note with # for each number, so that equal notes of several frames can be counted together.
inline std::string without_numbers(const std::string& note) {
  std::string text;
  const auto digit = [&](std::size_t i) { return std::isdigit(static_cast<unsigned char>(note[i])) != 0; };
  for (std::size_t i = 0; i < note.size(); ++i) {
    const bool part_of_word = i > 0 && (std::isalpha(static_cast<unsigned char>(note[i - 1])) != 0);
    if (!digit(i) || part_of_word) {
      text += note[i];
      continue;
    }
    while (i + 1 < note.size() &&
           (digit(i + 1) || (note[i + 1] == '.' && i + 2 < note.size() && digit(i + 2))))
      ++i;
    text += '#';
  }
  return text;
}

/// Sums of the reports of all frames, per stage.
class StageTotals {
 public:
  StageTotals() = default;
  /// In the order of the pipeline. Stages that were never reached are included.
  explicit StageTotals(const Pipeline& pipeline) {
    for (const CallPoint point : {CallPoint::BeforePose, CallPoint::AfterPose, CallPoint::AtKeyframe})
      if (const Stage* root = pipeline.stages(point))
        root->for_each([&](const Stage& stage, int depth) {
          StageTotal total;
          total.call_point = to_string(point);
          total.name = stage.name(), total.path = stage.path(), total.depth = depth;
          total.filter = dynamic_cast<const FilterStage*>(&stage) != nullptr;
          stages_.push_back(std::move(total));
        });
  }

  void add(const FrameReport& report) {
    for (const StageReport& stage : report.stages) {
      StageTotal* total = find(to_string(report.call_point), stage);
      if (total == nullptr) continue;
      ++total->frames;
      total->skipped += stage.skipped, total->failed += stage.failed;
      total->judged += static_cast<double>(stage.judged),
          total->dynamic += static_cast<double>(stage.dynamic);
      total->unknown += static_cast<double>(stage.unknown), total->prior += static_cast<double>(stage.prior);
      total->time_ms += stage.time_ms;
      total->times_ms.push_back(static_cast<float>(stage.time_ms));
      if (!stage.note.empty()) ++total->notes[without_numbers(stage.note)];
    }
  }
  void add(const StageTotals& other) {
    if (stages_.empty())
      stages_ = other.stages_;
    else
      for (std::size_t k = 0; k < std::min(stages_.size(), other.stages_.size()); ++k) {
        StageTotal& to = stages_[k];
        const StageTotal& from = other.stages_[k];
        to.frames += from.frames, to.skipped += from.skipped, to.failed += from.failed;
        to.judged += from.judged, to.dynamic += from.dynamic, to.unknown += from.unknown,
            to.prior += from.prior;
        to.time_ms += from.time_ms;
        to.times_ms.insert(to.times_ms.end(), from.times_ms.begin(), from.times_ms.end());
        for (const auto& [note, frames] : from.notes) to.notes[note] += frames;
      }
  }

  const std::vector<StageTotal>& stages() const { return stages_; }
  bool empty() const { return stages_.empty(); }
  /// True if a rejector was called in at least one frame.
  bool any_reached() const {
    return std::any_of(stages_.begin(), stages_.end(),
                       [](const StageTotal& stage) { return stage.filter && stage.frames > 0; });
  }
  /// True if there are rejectors and all were skipped in all frames.
  bool all_skipped() const {
    bool any = false;
    for (const StageTotal& stage : stages_) {
      if (!stage.filter || stage.frames == 0) continue;
      if (stage.skipped < stage.frames) return false;
      any = true;
    }
    return any;
  }
  /// Lines such as "semantic_box: skipped: no boxes", without duplicates.
  std::vector<std::string> reasons() const {
    std::vector<std::string> all;
    for (const StageTotal& stage : stages_)
      for (const auto& [note, frames] : stage.notes) {
        const bool why = note.rfind("skipped: ", 0) == 0 || note.rfind("failed: ", 0) == 0;
        const std::string line = stage.name + ": " + note;
        if (why && std::find(all.begin(), all.end(), line) == all.end()) all.push_back(line);
      }
    return all;
  }

 private:
  StageTotal* find(const std::string& call_point, const StageReport& report) {
    for (StageTotal& stage : stages_)
      if (stage.path == report.path && stage.name == report.name && stage.call_point == call_point)
        return &stage;
    return nullptr;
  }

  std::vector<StageTotal> stages_;
};

/// Counts as means per frame, times as medians. Notes with their number of frames.
inline Json to_json(const StageTotals& totals) {
  Json stages = Json::array();
  for (const StageTotal& s : totals.stages()) {
    Json notes = Json::array();
    for (const auto& [note, frames] : s.notes) notes.push_back({{"note", note}, {"frames", frames}});
    stages.push_back({{"call_point", s.call_point},
                      {"name", s.name},
                      {"path", s.path},
                      {"depth", s.depth},
                      {"frames", s.frames},
                      {"skipped", s.skipped},
                      {"failed", s.failed},
                      {"judged", s.mean(s.judged)},
                      {"dynamic", s.mean(s.dynamic)},
                      {"unknown", s.mean(s.unknown)},
                      {"prior", s.mean(s.prior)},
                      {"ms", s.median_ms()},
                      {"ms_mean", s.mean(s.time_ms)},
                      {"notes", notes}});
  }
  return stages;
}

/// A table of the stages as text. Means and medians are over the frames that reached the stage.
inline std::string stages_text(const StageTotals& totals, bool wide) {
  if (totals.empty()) return "";
  Table table({{"stage, mean counts", true},
               {"frames", false, 2},
               {"judged"},
               {"dynamic"},
               {"unknown"},
               {"suspects", false, 1},
               {"skipped"},
               {"failed"},
               {"median ms"}});
  std::string notes;
  std::set<std::string> said;
  for (const StageTotal& s : totals.stages()) {
    const bool root = s.depth == 0;
    const std::string blanks(2 * static_cast<std::size_t>(s.depth), ' ');
    table.add({blanks + s.name + (root ? " (" + s.call_point + ")" : ""), std::to_string(s.frames),
               cell(s.mean(s.judged), 0), cell(s.mean(s.dynamic), 0), cell(s.mean(s.unknown), 0),
               s.prior > 0 ? cell(s.mean(s.prior), 0) : "", s.skipped > 0 ? std::to_string(s.skipped) : "",
               s.failed > 0 ? std::to_string(s.failed) : "", cell(s.median_ms(), 2)});
    std::vector<std::pair<std::size_t, std::string>> sorted;
    for (const auto& [note, frames] : s.notes) sorted.emplace_back(frames, note);
    std::stable_sort(sorted.begin(), sorted.end(),
                     [](const auto& a, const auto& b) { return a.first > b.first; });
    constexpr std::size_t kMost = 4;
    for (std::size_t k = 0; k < std::min(kMost, sorted.size()); ++k) {
      const std::string line = fmt::format("{}: {} ({} {})", s.name, sorted[k].second, sorted[k].first,
                                           sorted[k].first == 1 ? "frame" : "frames");
      if (!said.insert(line).second) continue;  // two stages have the same name
      std::string block = wrapped(line, wide ? 1000 : text_columns(), 4);
      if (!block.empty()) block[2] = '-';
      notes += block;
    }
  }
  std::string text = table.text(wide ? 0 : text_columns(), nullptr, 2);
  return text + notes;
}

}  // namespace dynfilter::command
