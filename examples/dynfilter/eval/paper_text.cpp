// SPDX-License-Identifier: MIT
#include <dynfilter/config/numbers.hpp>
#include <dynfilter/core/error.hpp>

#include "eval/paper_content.hpp"
#include "eval/paper_table.hpp"
#include "eval/table_text.hpp"

namespace dynfilter::eval {
namespace {

using paper::Better;
using paper::Column;

std::string markdown_head(const Column& column) {
  const std::string group = column.group, unit = column.unit;
  std::string head = (group.empty() ? "" : group + " ") + column.name;
  if (!unit.empty()) head += " (" + unit + ")";
  if (column.better != Better::Neither) head += column.better == Better::Less ? " ↓" : " ↑";
  return markdown_cell(head);
}

std::string markdown_text(const paper::Cell& cell) {
  const std::string text = markdown_cell(cell.text);
  return cell.best ? "**" + text + "**" : text;
}

std::string digits_of(double value) {
  constexpr int kAllDigits = 17;
  return std::isfinite(value) ? number_text(value, kAllDigits) : "";
}

/// Per row of the comparison: the columns in which it is best of its sequence, with blanks between.
std::vector<std::string> best_columns(const paper::Content& content, std::size_t rows) {
  std::vector<std::string> names(rows);
  for (const paper::Block& block : content.blocks)
    for (const paper::Row& row : block.rows)
      for (std::size_t c = 0; c < content.columns.size(); ++c)
        if (row.cells[c].best)
          names[row.index] += std::string(names[row.index].empty() ? "" : " ") + content.columns[c].key;
  return names;
}

}  // namespace

std::string markdown_table(const Comparison& comparison, const Provenance& provenance) {
  const paper::Content content = paper::content_of(comparison, provenance);
  std::string head = "| Sequence | Pipeline |", rule = "|---|---|", body;
  for (const Column& column : content.columns) head += " " + markdown_head(column) + " |", rule += "---:|";
  for (const paper::Block& block : content.blocks)
    for (const paper::Row& row : block.rows) {
      body += "| " + markdown_cell(block.title) + " | " + markdown_cell(row.pipeline) + " |";
      for (const paper::Cell& cell : row.cells) body += " " + markdown_text(cell) + " |";
      body += "\n";
    }
  std::string notes;
  for (const std::string& note : content.notes) notes += "\n" + markdown_cell(note) + "\n";
  return markdown_cell(content.caption) + "\n\n" + head + "\n" + rule + "\n" + body + notes;
}

std::string csv_table(const Comparison& comparison, const Provenance& provenance) {
  const std::vector<std::string> best =
      best_columns(paper::content_of(comparison, provenance), comparison.rows.size());
  std::string csv = "sequence,pipeline,alignment,runs_with_ate,frames,tracked_frames";
  for (const Column& column : paper::columns()) csv += std::string(",") + column.key;
  csv += ",best,reference,pairs,first_s,last_s,version,commit,machine\n";
  for (std::size_t i = 0; i < comparison.rows.size(); ++i) {
    const ComparedRow& row = comparison.rows[i];
    csv += csv_field(row.place) + "," + csv_field(row.pipeline) + "," +
           (row.runs_with_ate > 0 ? row.alignment : "") + "," + std::to_string(row.runs_with_ate) + "," +
           std::to_string(row.frames) + "," + std::to_string(row.tracked_frames);
    for (const Column& column : paper::columns()) csv += "," + digits_of(column.value(row));
    csv += "," + best[i] + "," + csv_field(comparison.reference) + "," +
           std::to_string(row.against_reference.pairs) + "," + digits_of(row.first_s) + "," +
           digits_of(row.last_s) + "," + provenance.version + "," + csv_field(provenance.commit) + "," +
           csv_field(provenance.machine) + "\n";
  }
  return csv;
}

std::string paper_table(const std::string& format, const Comparison& comparison,
                        const Provenance& provenance) {
  if (format == "latex") return latex_table(comparison, provenance);
  if (format == "markdown") return markdown_table(comparison, provenance);
  if (format == "csv") return csv_table(comparison, provenance);
  throw Error("`" + format + "` is no format of a table: latex, markdown, csv");
}

}  // namespace dynfilter::eval
