// SPDX-License-Identifier: MIT
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "bench/manifest.hpp"
#include "bench/results.hpp"
#include "report/page.hpp"
#include "text/table.hpp"

namespace dynfilter::command {

namespace detail_bench {

inline constexpr const char* kStyle =
    ":root{color-scheme:light dark;--line:#8884;--soft:#8881;--bar:#2a7ab9;--paper:#999}"
    "body{font:15px/1.5 system-ui,sans-serif;max-width:62rem;margin:1.5rem auto;padding:0 1rem}"
    "h1{font-size:1.45rem}h2{font-size:1.1rem;margin:1.8rem 0 .3rem}.wide{overflow-x:auto}"
    "table{border-collapse:collapse;width:100%;font-variant-numeric:tabular-nums}"
    "th,td{padding:.25rem .6rem;border-bottom:1px solid var(--line);text-align:right;white-space:nowrap}"
    "th:first-child,td:first-child{text-align:left}.bars td:last-child{width:32%;text-align:left}"
    "th{font-weight:600}.paper{opacity:.75}.best{font-weight:700;background:var(--soft)}"
    ".bar{display:block;height:.7rem;background:var(--bar)}.paper .bar{background:var(--paper)}"
    "@media(max-width:620px){table{font-size:.85rem}th,td{padding:.2rem .4rem}"
    ".bars th:last-child,.bars td:last-child{display:none}}"
    "@media print{table{font-size:.75rem}table,h2{break-inside:avoid}h2{break-after:avoid}}";

inline constexpr const char* kIntroduction =
    "<p>ATE is the RMSE in centimetres after alignment: SE(3), or Sim(3) for systems of one camera, which "
    "have no scale. Read it beside the tracked frames. Figures of papers are grey. They are of other front "
    "ends, often medians of many runs. Compare rows of one alignment: Sim(3) also fits the scale, which "
    "lowers the error. The least ATE of each alignment is bold, of our runs and of the papers.</p>\n";

/// A bar as long as the ATE, of at most the largest one shown. `none` does not set the scale, as it would
/// make all others invisible.
inline std::string bar(const BenchRow& row, double largest_m) {
  if (!std::isfinite(row.ate_rmse_m) || !(largest_m > 0)) return "";
  if (row.system == "none" && row.ate_rmse_m > largest_m) return "longer than the scale";
  return fmt::format(R"(<svg class="bar" width="{:.1f}%" aria-hidden="true"></svg>)",
                     100 * std::min(1.0, row.ate_rmse_m / largest_m));
}

inline std::string name_of(const BenchRow& row) {
  const std::string name = report::escaped(row.system);
  return row.link.empty() ? name : fmt::format(R"(<a href="{}">{}</a>)", report::escaped(row.link), name);
}

inline const char* row_class(const BenchRow& row) {
  return row.state == "published" ? R"( class="paper")" : "";
}

inline std::string row_html(const BenchRow& row, double largest_m) {
  const std::string tracked =
      row.frames > 0 ? fmt::format("{}/{}", row.tracked_frames, row.frames) : report::escaped(row.state);
  const auto figure = [](double value, int digits) {
    return std::isfinite(value) ? cell(value, digits) : std::string();
  };
  return fmt::format(
      "<tr{}><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>\n",
      row_class(row), name_of(row), row.alignment, tracked, ate_cm_text(row), figure(row.recall, 3),
      figure(row.total_ms, 1), bar(row, largest_m));
}

inline double largest_ate_m(const std::vector<BenchRow>& rows, const std::string& sequence) {
  double largest_m = 0;
  for (const BenchRow& row : rows)
    if (row.sequence == sequence && row.system != "none" && std::isfinite(row.ate_rmse_m))
      largest_m = std::max(largest_m, row.ate_rmse_m);
  return largest_m;
}

inline const BenchRow* find_row(const std::vector<BenchRow>& rows, const std::string& sequence,
                                const BenchRow& system) {
  const auto found = std::find_if(rows.begin(), rows.end(), [&](const BenchRow& row) {
    return row.sequence == sequence && row.system == system.system && row.alignment == system.alignment;
  });
  return found == rows.end() ? nullptr : &*found;
}

/// With any figure, of ours or of a paper.
inline std::vector<std::string> shown_sequences(const Manifest& manifest, const std::vector<BenchRow>& rows) {
  std::vector<std::string> shown;
  for (const BenchSequence& sequence : manifest.sequences) {
    const auto has_figure = [&](const BenchRow& row) {
      return row.sequence == sequence.name && row.state != "missing";
    };
    if (std::any_of(rows.begin(), rows.end(), has_figure)) shown.push_back(sequence.name);
  }
  return shown;
}

/// The ATE of a system on a sequence. The least ones of an alignment are bold, of our runs and of the papers.
inline std::string overview_cell(const std::vector<BenchRow>& rows, const std::string& sequence,
                                 const BenchRow& system) {
  const BenchRow* row = find_row(rows, sequence, system);
  if (row == nullptr || !std::isfinite(row->ate_rmse_m)) return "<td></td>";
  const bool best = std::none_of(rows.begin(), rows.end(), [&](const BenchRow& other) {
    return other.sequence == sequence && (other.state == "published") == (row->state == "published") &&
           other.alignment == row->alignment && other.ate_rmse_m < row->ate_rmse_m;
  });
  return fmt::format("<td{}>{}</td>", best ? R"( class="best")" : "", ate_cm_text(*row));
}

/// All systems on all sequences.
inline std::string overview(const std::vector<std::string>& sequences, const std::vector<BenchRow>& rows) {
  std::string html = "<div class=\"wide\"><table><tr><th>ATE cm</th><th>alignment</th>";
  for (const std::string& sequence : sequences) html += "<th>" + report::escaped(sequence) + "</th>";
  html += "</tr>\n";
  std::vector<std::string> done;
  for (const BenchRow& first : rows) {
    const std::string name = first.system + ", " + first.alignment;
    if (first.state == "missing" || std::find(done.begin(), done.end(), name) != done.end()) continue;
    done.push_back(name);
    html += fmt::format("<tr{}><td>{}</td><td>{}</td>", row_class(first), report::escaped(first.system),
                        first.alignment);
    for (const std::string& sequence : sequences) html += overview_cell(rows, sequence, first);
    html += "</tr>\n";
  }
  return html + "</table></div>\n";
}

inline std::string sequence_html(const std::string& sequence, const std::vector<BenchRow>& rows) {
  std::string html = fmt::format(
      "<h2>{}</h2>\n<div class=\"wide\"><table class=\"bars\"><tr><th>system</th><th>alignment</th>"
      "<th>tracked</th><th>ATE cm</th><th>recall</th><th>ms</th><th></th></tr>\n",
      report::escaped(sequence));
  const double largest_m = largest_ate_m(rows, sequence);
  for (const BenchRow& row : shown_rows(rows))
    if (row.sequence == sequence) html += row_html(row, largest_m);
  return html + "</table></div>\n";
}

/// What the papers' systems are, where the manifest says it.
inline std::string sources_html(const Manifest& manifest) {
  std::string items;
  for (const PublishedSystem& system : manifest.published)
    if (!system.note.empty())
      items += fmt::format("<li>{}, {}: {}</li>\n", report::escaped(system.name), system.alignment,
                           report::escaped(system.note));
  return items.empty() ? "" : "<h2>Figures of papers</h2>\n<ul>\n" + items + "</ul>\n";
}

inline std::string missing_html(const Manifest& manifest, const std::vector<BenchRow>& rows) {
  std::string names;
  for (const BenchRow& row : shown_rows(rows))
    if (row.state == "missing") names += (names.empty() ? "" : ", ") + row.sequence;
  if (names.empty()) return "";
  return "<h2>Not measured</h2>\n<p>" + report::escaped(names) + ": no data. Download " +
         report::escaped(manifest.download) + ".</p>\n";
}

}  // namespace detail_bench

/// One page without references to others, except links to the pages of the runs.
inline std::string bench_page(const Manifest& manifest, const std::vector<BenchRow>& rows) {
  const std::string title = report::escaped("dynfilter bench " + manifest.name);
  const std::vector<std::string> sequences = detail_bench::shown_sequences(manifest, rows);
  std::string page = fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">"
      "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src "
      "'unsafe-inline'\">"
      "<title>{0}</title><style>{1}</style></head><body><h1>{0}</h1>\n{2}",
      title, detail_bench::kStyle, detail_bench::kIntroduction);
  page += detail_bench::overview(sequences, rows);
  for (const std::string& sequence : sequences) page += detail_bench::sequence_html(sequence, rows);
  return page + detail_bench::sources_html(manifest) + detail_bench::missing_html(manifest, rows) +
         "</body></html>\n";
}

}  // namespace dynfilter::command
