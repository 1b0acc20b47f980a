// SPDX-License-Identifier: MIT
#include "eval/paper_content.hpp"

#include <algorithm>
#include <dynfilter/config/numbers.hpp>
#include <set>

namespace dynfilter::eval::paper {
namespace {

/// Below this, no digit of p is left.
constexpr double kLeastShownP = 0.0005;

/// `oracle` knows the truth. `none` keeps all and costs nothing.
bool is_ranked(const ComparedRow& row, const Column& column) {
  const std::string key = column.key;
  return row.pipeline != "oracle" && !(row.pipeline == "none" && (key == "static_kept" || key == "cpu_ms"));
}

std::string text_of(const ComparedRow& row, const Column& column) {
  const std::string key = column.key;
  const double value = column.value(row);
  if (key == "runs" && row.runs_with_ate > 0 && row.runs_with_ate < row.runs)
    return std::to_string(row.runs_with_ate) + "/" + std::to_string(row.runs);
  if (!std::isfinite(value)) return "-";
  if (key != "p_value") return fixed_text(value, column.digits);
  return (value < kLeastShownP ? "<0.001" : fixed_text(value, column.digits)) +
         (value < kSignificance ? "*" : "");
}

/// As printed: figures that read the same are equally good. Empty where all of them are.
std::string best_text(const std::vector<const ComparedRow*>& rows, const Column& column) {
  double best = NAN;
  std::set<std::string> texts;
  for (const ComparedRow* row : rows) {
    const double value = column.value(*row);
    if (!std::isfinite(value) || !is_ranked(*row, column)) continue;
    texts.insert(fixed_text(value, column.digits));
    best = column.better == Better::Less ? std::fmin(best, value) : std::fmax(best, value);
  }
  return column.better == Better::Neither || texts.size() < 2 ? "" : fixed_text(best, column.digits);
}

/// The same of all rows, and each with an ATE: a note says it.
bool is_same_count(const std::vector<ComparedRow>& rows) {
  return std::all_of(rows.begin(), rows.end(), [&rows](const ComparedRow& row) {
    return row.runs == rows[0].runs && (row.runs_with_ate == row.runs || row.runs_with_ate == 0);
  });
}

std::vector<Column> shown_columns(const std::vector<ComparedRow>& rows) {
  const bool several =
      std::any_of(rows.begin(), rows.end(), [](const ComparedRow& row) { return row.runs > 1; });
  std::vector<Column> shown;
  for (Column column : columns()) {
    const bool any = std::any_of(rows.begin(), rows.end(),
                                 [&](const ComparedRow& row) { return std::isfinite(column.value(row)); });
    const bool counted = column.key == std::string("runs") && is_same_count(rows);
    if (!any || counted || (column.of_several && !several)) continue;
    if (std::string(column.key) == "ate_median_m" && !several) column.group = "", column.name = "ATE";
    shown.push_back(column);
  }
  return shown;
}

/// The one of all rows; "" if they differ or none has an ATE.
std::string common_alignment(const std::vector<ComparedRow>& rows) {
  std::set<std::string> found;
  for (const ComparedRow& row : rows)
    if (row.runs_with_ate > 0) found.insert(row.alignment);
  return found.size() == 1 ? *found.begin() : "";
}

std::string block_title(const ComparedRow& row, bool with_alignment) {
  return row.place + (with_alignment && row.runs_with_ate > 0 ? ", aligned by " + row.alignment : "");
}

std::vector<Block> blocks_of(const std::vector<ComparedRow>& rows, const std::vector<Column>& shown) {
  const bool with_alignment = common_alignment(rows).empty();
  std::vector<Block> blocks;
  std::vector<std::string> done;
  for (const ComparedRow& first : rows) {
    if (std::find(done.begin(), done.end(), first.scene) != done.end()) continue;
    done.push_back(first.scene);
    std::vector<const ComparedRow*> own;
    for (const ComparedRow& row : rows)
      if (row.scene == first.scene) own.push_back(&row);
    Block block{block_title(first, with_alignment), {}};
    for (const ComparedRow* row : own)
      block.rows.push_back({static_cast<std::size_t>(row - rows.data()), row->pipeline, {}});
    for (const Column& column : shown) {
      const std::string best = best_text(own, column);
      for (std::size_t i = 0; i < own.size(); ++i) {
        const std::string text = text_of(*own[i], column);
        block.rows[i].cells.push_back({text, text == best && is_ranked(*own[i], column)});
      }
    }
    blocks.push_back(std::move(block));
  }
  return blocks;
}

std::string range_of(std::size_t least, std::size_t most) {
  return std::to_string(least) + (least < most ? " to " + std::to_string(most) : "");
}

std::string joined(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

std::string runs_note(const Comparison& comparison) {
  const std::vector<ComparedRow>& rows = comparison.rows;
  std::size_t least = rows[0].runs, most = 0;
  for (const ComparedRow& row : rows) least = std::min(least, row.runs), most = std::max(most, row.runs);
  if (most < 2) return "";
  const std::string variants = joined(comparison.variants);
  return "Median, worst, mean and standard deviation (n - 1) of " + range_of(least, most) + " runs per row" +
         (variants.empty() ? "" : " (frames " + variants + ")") + ". Other figures: median of these runs.";
}

bool has_column(const std::vector<Column>& shown, const std::string& key) {
  return std::any_of(shown.begin(), shown.end(), [&](const Column& c) { return key == c.key; });
}

std::string meanings(const std::vector<Column>& shown) {
  const auto has = [&shown](const char* key) { return has_column(shown, key); };
  std::string text;
  if (has("tracked_percent")) text += "Tracked: frames with a pose, of all; lost frames lower the ATE. ";
  if (has("recall")) text += "Recall: share of the features on movers that is rejected. ";
  if (has("static_kept")) text += "Kept: share of the static features that is kept. ";
  if (has("cpu_ms")) text += "CPU: time of all threads per frame, odometry included. ";
  if (!text.empty()) text.pop_back();
  return text;
}

std::string ranking_note(const std::vector<ComparedRow>& rows) {
  const auto has = [&rows](const char* name) {
    return std::any_of(rows.begin(), rows.end(),
                       [&](const ComparedRow& row) { return row.pipeline == name; });
  };
  std::string text;
  if (has("oracle")) text = "oracle, which knows the truth";
  if (has("none"))
    text += std::string(text.empty() ? "" : "; and ") + "none in Kept and CPU, as it rejects nothing";
  return text.empty() ? "" : "Not ranked: " + text + ".";
}

std::string test_note(const Comparison& comparison) {
  std::size_t least = 0, most = 0;
  for (const ComparedRow& row : comparison.rows) {
    const std::size_t pairs = row.against_reference.pairs;
    if (pairs == 0) continue;
    least = least == 0 ? pairs : std::min(least, pairs), most = std::max(most, pairs);
  }
  if (most == 0) return "";
  std::string text = std::string("p: two-sided Wilcoxon signed-rank test") +
                     (most <= SignedRank::kMostExact ? ", exact" : "") + ", of the ATE against " +
                     comparison.reference + ", paired by seed and variant (n = " + range_of(least, most) +
                     "), not corrected for several comparisons. ";
  if (least_signed_rank_p(most) >= kSignificance)
    return text + "So few pairs cannot tell a difference from noise: p is at least " +
           fixed_text(least_signed_rank_p(most), 3) + ".";
  text += "*: p < " + fixed_text(kSignificance, 2);
  return text + (comparison.variants.empty() ? ", more than noise."
                                             : ". Variants of a sequence share frames, so p is too small.");
}

std::string data_note(const std::vector<ComparedRow>& rows) {
  std::string text;
  std::set<std::string> done;
  for (const ComparedRow& row : rows) {
    if (!done.insert(row.scene).second) continue;
    text += std::string(text.empty() ? "Data: " : "; ") + row.place +
            (joined(row.sequences) == row.place ? "" : " (" + joined(row.sequences) + ")") + ", " +
            std::to_string(row.longest_run) + " frames";
    if (std::isfinite(row.first_s))
      text += ", stamps " + fixed_text(row.first_s, 3) + " to " + fixed_text(row.last_s, 3) + " s";
  }
  return text.empty() ? "" : text + ".";
}

std::string program_note(const Provenance& provenance) {
  std::string commit = provenance.commit.empty() ? "not known" : provenance.commit;
  if (commit.back() == '+') commit.replace(commit.size() - 1, 1, " with changes");
  return "dynfilter " + provenance.version + ", commit " + commit + ", on " + provenance.machine + ".";
}

std::string failure_note(const std::vector<ComparedRow>& rows) {
  std::string names;
  for (const ComparedRow& row : rows)
    if (row.failed_runs > 0) names += (names.empty() ? "" : ", ") + row.pipeline + " on " + row.place;
  return names.empty() ? "" : "Failed, without figures: " + names + ".";
}

std::string caption_of(const Comparison& comparison, const std::vector<Column>& shown) {
  const bool arrows =
      std::any_of(shown.begin(), shown.end(), [](const Column& c) { return c.better != Better::Neither; });
  std::string text = "Comparison of pipelines. ";
  if (has_column(shown, "ate_median_m")) {
    const std::string alignment = common_alignment(comparison.rows);
    text = "Trajectory error of the pipelines: RMSE of the absolute error (ATE) after " +
           (alignment.empty() ? "the alignment that stands at each sequence" : alignment + " alignment") +
           (has_column(shown, "rpe_m") ? ", and of the relative one (RPE) over 1 s. " : ". ");
  }
  return text +
         (arrows ? "An arrow down: less is better; up: more is better. Bold: best of the sequence." : "");
}

}  // namespace

const std::vector<Column>& columns() {
  using R = ComparedRow;
  static const std::vector<Column> all = {
      {"runs", "", "Runs", "", 0, Better::Neither, true,
       [](const R& r) { return static_cast<double>(r.runs); }},
      {"tracked_percent", "", "Tracked", "%", 1, Better::More, false,
       [](const R& r) { return r.has_poses ? r.tracked_percent() : NAN; }},
      {"ate_median_m", "ATE", "median", "m", 4, Better::Less, false,
       [](const R& r) { return r.ate_median_m; }},
      {"ate_worst_m", "ATE", "worst", "m", 4, Better::Less, true, [](const R& r) { return r.ate_worst_m; }},
      {"ate_mean_m", "ATE", "mean", "m", 4, Better::Less, true, [](const R& r) { return r.ate_mean_m; }},
      {"ate_std_m", "ATE", "std", "m", 4, Better::Less, true, [](const R& r) { return r.ate_std_m; }},
      {"rpe_m", "", "RPE", "m", 4, Better::Less, false, [](const R& r) { return r.rpe_median_m; }},
      {"recall", "", "Recall", "", 3, Better::More, false, [](const R& r) { return r.recall; }},
      {"static_kept", "", "Kept", "", 3, Better::More, false, [](const R& r) { return r.static_kept; }},
      {"cpu_ms", "", "CPU", "ms", 1, Better::Less, false, [](const R& r) { return r.cpu_ms; }},
      {"p_value", "", "p", "", 3, Better::Neither, true, [](const R& r) { return r.against_reference.p; }}};
  return all;
}

Content content_of(const Comparison& comparison, const Provenance& provenance) {
  Content content;
  content.columns = shown_columns(comparison.rows);
  content.blocks = blocks_of(comparison.rows, content.columns);
  content.caption = caption_of(comparison, content.columns);
  if (comparison.rows.empty()) return content;
  for (std::string note :
       {runs_note(comparison), meanings(content.columns), ranking_note(comparison.rows),
        has_column(content.columns, "p_value") ? test_note(comparison) : "", failure_note(comparison.rows),
        program_note(provenance), data_note(comparison.rows)})
    if (!note.empty()) content.notes.push_back(std::move(note));
  return content;
}

}  // namespace dynfilter::eval::paper
