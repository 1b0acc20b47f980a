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
    ":root{color-scheme:light dark;--line:#8884;--bar:#2a7ab9;--paper:#999}"
    "body{font:16px/1.5 system-ui,sans-serif;max-width:60rem;margin:2rem auto;padding:0 1rem}"
    "table{border-collapse:collapse;width:100%;margin:1rem 0}"
    "th,td{padding:.25rem .5rem;border-bottom:1px solid var(--line);text-align:right}"
    "th:first-child,td:first-child{text-align:left}td:last-child{width:30%;text-align:left}"
    ".paper{opacity:.75}.bar{display:block;height:.7rem;background:var(--bar)}"
    ".paper .bar{background:var(--paper)}.wide{overflow-x:auto}";

/// A bar as long as the ATE, of at most the largest one shown.
inline std::string bar(double ate_m, double largest_m) {
  if (!std::isfinite(ate_m) || !(largest_m > 0)) return "";
  return fmt::format(R"(<svg class="bar" width="{:.1f}%" aria-hidden="true"></svg>)",
                     100 * std::min(1.0, ate_m / largest_m));
}

inline std::string row_html(const BenchRow& row, double largest_m) {
  const std::string name = report::escaped(row.system);
  const std::string system =
      row.link.empty() ? name : fmt::format(R"(<a href="{}">{}</a>)", report::escaped(row.link), name);
  const bool paper = row.state == "published";
  const std::string tracked =
      row.frames > 0 ? fmt::format("{}/{}", row.tracked_frames, row.frames) : report::escaped(row.state);
  return fmt::format(
      "<tr{}><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>\n",
      paper ? R"( class="paper")" : "", system, row.alignment, tracked, cell(100 * row.ate_rmse_m, 1),
      cell(row.recall, 3), cell(row.total_ms, 1), bar(row.ate_rmse_m, largest_m));
}

/// Of the systems that are of use: `none` would make all other bars invisible.
inline double largest_ate_m(const std::vector<BenchRow>& rows, const std::string& sequence) {
  double largest_m = 0;
  for (const BenchRow& row : rows)
    if (row.sequence == sequence && row.system != "none" && std::isfinite(row.ate_rmse_m))
      largest_m = std::max(largest_m, row.ate_rmse_m);
  return largest_m;
}

}  // namespace detail_bench

/// One page without references to others, except links to the pages of the runs.
inline std::string bench_page(const Manifest& manifest, const std::vector<BenchRow>& rows) {
  const std::string title = report::escaped("dynfilter bench " + manifest.name);
  std::string page = fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">"
      "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src "
      "'unsafe-inline'\">"
      "<title>{0}</title><style>{1}</style></head><body><h1>{0}</h1>\n<p>ATE is the RMSE after alignment. "
      "Read "
      "it beside the tracked frames. Figures of papers are grey. They are of other front ends, often medians "
      "of "
      "many runs. The bars compare the systems of one sequence, without <code>none</code>.</p>\n",
      title, detail_bench::kStyle);
  bool missing = false;
  for (const BenchSequence& sequence : manifest.sequences) {
    page += fmt::format(
        "<h2>{}</h2>\n<div class=\"wide\"><table><tr><th>system</th><th>alignment</th>"
        "<th>tracked</th><th>ATE cm</th><th>recall</th><th>ms</th><th></th></tr>\n",
        report::escaped(sequence.name));
    const double largest_m = detail_bench::largest_ate_m(rows, sequence.name);
    for (const BenchRow& row : shown_rows(rows)) {
      if (row.sequence != sequence.name) continue;
      page += detail_bench::row_html(row, largest_m);
      missing = missing || row.state == "missing";
    }
    page += "</table></div>\n";
  }
  if (missing) page += "<p>Missing: " + report::escaped(manifest.download) + "</p>\n";
  return page + "</body></html>\n";
}

}  // namespace dynfilter::command
