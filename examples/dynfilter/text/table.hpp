// SPDX-License-Identifier: MIT
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "eval/table_text.hpp"
#include "terminal.hpp"

namespace dynfilter::command {

/// A figure in a table; "-" for NaN.
inline std::string cell(double value, int digits) {
  return std::isfinite(value) ? fmt::format("{:.{}f}", value, digits) : "-";
}

struct Column {
  std::string head;
  bool text = false;  ///< left-aligned; figures are right-aligned
  int rank = 0;       ///< in narrow tables the highest rank is left out first; 0: never left out
};

/// A table as text. Empty columns are left out.
/// The least important columns are left out if the table is too wide.
class Table {
 public:
  explicit Table(std::vector<Column> columns) : columns_(std::move(columns)) {}

  void add(std::vector<std::string> row) { rows_.push_back(std::move(row)); }
  bool empty() const { return rows_.empty(); }

  /// All columns with any entry, as Markdown.
  std::string markdown() const {
    std::string head = "|", rule = "|", body;
    for (std::size_t c = 0; c < columns_.size(); ++c) {
      if (!is_used(c)) continue;
      head += " " + eval::markdown_cell(columns_[c].head) + " |";
      rule += columns_[c].text ? "---|" : "---:|";
    }
    for (const auto& row : rows_) {
      body += "|";
      for (std::size_t c = 0; c < columns_.size(); ++c)
        if (is_used(c)) body += " " + eval::markdown_cell(row[c]) + " |";
      body += "\n";
    }
    return head + "\n" + rule + "\n" + body;
  }

  /// `room`: characters per line, 0: no limit. `left_out` receives the heads of the columns that were left
  /// out because of it.
  std::string text(std::size_t room, std::vector<std::string>* left_out = nullptr,
                   std::size_t indent = 0) const {
    std::vector<std::size_t> shown;
    for (std::size_t c = 0; c < columns_.size(); ++c)
      if (is_used(c)) shown.push_back(c);
    while (room > 0 && indent + width(shown) > room) {
      const auto least = std::max_element(shown.begin(), shown.end(), [&](std::size_t a, std::size_t b) {
        return columns_[a].rank < columns_[b].rank;
      });
      if (least == shown.end() || columns_[*least].rank == 0) break;
      if (left_out != nullptr) left_out->push_back(columns_[*least].head);
      shown.erase(least);
    }
    std::vector<std::size_t> widths;
    for (const std::size_t c : shown) widths.push_back(column_width(c));
    if (room > 0 && indent + width(shown) > room) shorten(shown, widths, indent + width(shown) - room);
    std::vector<std::string> heads;
    for (const Column& column : columns_) heads.push_back(column.head);
    std::string text = line(heads, shown, widths, indent);
    for (const auto& row : rows_) text += line(row, shown, widths, indent);
    return text;
  }

 private:
  static constexpr std::size_t kGap = 2, kLeastText = 12;

  bool is_used(std::size_t c) const {
    return std::any_of(rows_.begin(), rows_.end(),
                       [c](const auto& row) { return !row[c].empty() && row[c] != "-"; });
  }
  std::size_t column_width(std::size_t c) const {
    std::size_t most = letters(columns_[c].head);
    for (const auto& row : rows_) most = std::max(most, letters(row[c]));
    return most;
  }
  std::size_t width(const std::vector<std::size_t>& shown) const {
    std::size_t sum = 0;
    for (const std::size_t c : shown) sum += column_width(c) + kGap;
    return sum > kGap ? sum - kGap : 0;
  }
  /// Shortens the widest text column.
  void shorten(const std::vector<std::size_t>& shown, std::vector<std::size_t>& widths,
               std::size_t too_much) const {
    std::size_t widest = shown.size();
    for (std::size_t k = 0; k < shown.size(); ++k)
      if (columns_[shown[k]].text && (widest == shown.size() || widths[k] > widths[widest])) widest = k;
    if (widest == shown.size()) return;
    widths[widest] = std::max(kLeastText, widths[widest] > too_much ? widths[widest] - too_much : 0);
  }

  std::string line(const std::vector<std::string>& row, const std::vector<std::size_t>& shown,
                   const std::vector<std::size_t>& widths, std::size_t indent) const {
    std::string text(indent, ' ');
    for (std::size_t k = 0; k < shown.size(); ++k) {
      std::string entry = row[shown[k]];
      if (letters(entry) > widths[k]) entry = entry.substr(0, widths[k] - 2) + "..";
      const std::string blanks(widths[k] > letters(entry) ? widths[k] - letters(entry) : 0, ' ');
      text += (columns_[shown[k]].text ? entry + blanks : blanks + entry) + std::string(kGap, ' ');
    }
    const std::size_t end = text.find_last_not_of(' ');
    return text.substr(0, end == std::string::npos ? 0 : end + 1) + "\n";
  }

  std::vector<Column> columns_;
  std::vector<std::vector<std::string>> rows_;
};

/// Prints the table as wide as the terminal, or with all columns. Names the columns that are left out.
inline void print_table(const Table& table, bool wide) {
  std::vector<std::string> left_out;
  fmt::print("{}", table.text(wide ? 0 : text_columns(), &left_out));
  if (!left_out.empty())
    fmt::print("{}",
               wrapped(fmt::format("Not shown: {} (--wide).", fmt::join(left_out, ", ")), text_columns()));
}

}  // namespace dynfilter::command
