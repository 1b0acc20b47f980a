// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cstdint>

#include "eval/paper_content.hpp"
#include "eval/paper_table.hpp"

namespace dynfilter::eval {
namespace {

using paper::Better;
using paper::Column;
using paper::Content;

const char* latex_of(char c) {
  switch (c) {
    case '\\':
      return "\\textbackslash{}";
    case '~':
      return "\\textasciitilde{}";
    case '^':
      return "\\textasciicircum{}";
    case '<':
      return "\\textless{}";
    case '>':
      return "\\textgreater{}";
    case '|':
      return "\\textbar{}";
    case '"':
      return "''";
    case '_':
      return "\\_";
    case '&':
      return "\\&";
    case '%':
      return "\\%";
    case '$':
      return "\\$";
    case '#':
      return "\\#";
    case '{':
      return "\\{";
    case '}':
      return "\\}";
    default:
      return nullptr;
  }
}

/// Letters of Latin-1 that every LaTeX knows: the two bytes at `at` are one of them.
bool is_latin_letter(const std::string& text, std::size_t at) {
  if (static_cast<std::uint8_t>(text[at]) != 0xc3 || at + 1 >= text.size()) return false;
  const auto second = static_cast<std::uint8_t>(text[at + 1]);
  const std::uint8_t without_t1[] = {0x90, 0x97, 0x9e, 0xb0, 0xb7, 0xbe};  // eth, thorn, times, division
  return second >= 0x80 && second <= 0xbf &&
         std::find(std::begin(without_t1), std::end(without_t1), second) == std::end(without_t1);
}

/// What LaTeX would act on is shown as it is. What it cannot show becomes a question mark.
std::string escaped(const std::string& text) {
  std::string safe;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto byte = static_cast<std::uint8_t>(text[i]);
    if (is_latin_letter(text, i)) {
      safe += text.substr(i++, 2);
    } else if (byte >= 0x80) {
      if ((byte & 0xc0U) != 0x80) safe += '?';  // once for all bytes of a character
    } else if (byte < 0x20 || byte == 0x7f) {
      safe += ' ';
    } else if (text.compare(i, 2, "--") == 0) {
      safe += "-{}";  // two of them would become a dash
    } else if (const char* latex = latex_of(text[i])) {
      safe += latex;
    } else {
      safe += text[i];
    }
  }
  return safe;
}

std::string arrow(const Column& column) {
  if (column.better == Better::Neither) return "";
  return column.better == Better::Less ? " $\\downarrow$" : " $\\uparrow$";
}

std::string with_unit(const Column& column) {
  const std::string unit = column.unit;
  return unit.empty() ? "" : " [" + escaped(unit) + "]";
}

bool in_group(const Column& column) {
  return *column.group != '\0';
}

/// Columns of the same group that follow each other, from `begin` on.
std::size_t group_end(const std::vector<Column>& columns, std::size_t begin) {
  std::size_t end = begin;
  while (end < columns.size() && std::string(columns[end].group) == columns[begin].group) ++end;
  return end;
}

/// Groups with their lines below, names on top, units and arrows in the second line.
std::string heads(const std::vector<Column>& columns) {
  std::string first, lines, second = "Pipeline";
  for (std::size_t c = 0; c < columns.size();) {
    if (!in_group(columns[c])) {
      first += " & " + escaped(columns[c].name);
      second += " &" + with_unit(columns[c]) + arrow(columns[c]);
      ++c;
      continue;
    }
    const std::size_t end = group_end(columns, c);
    first += " & \\multicolumn{" + std::to_string(end - c) + "}{c}{" + escaped(columns[c].group) +
             with_unit(columns[c]) + arrow(columns[c]) + "}";
    lines += "\\cmidrule(lr){" + std::to_string(c + 2) + "-" + std::to_string(end + 1) + "}\n";
    for (; c < end; ++c) second += " & " + escaped(columns[c].name);
  }
  return first + " \\\\\n" + lines + second + " \\\\\n";
}

/// Letters of the widest row.
std::size_t letters(const Content& content) {
  std::size_t name = 0, figures = 0;
  for (const paper::Block& block : content.blocks)
    for (const paper::Row& row : block.rows) name = std::max(name, row.pipeline.size());
  for (std::size_t c = 0; c < content.columns.size(); ++c) {
    const Column& column = content.columns[c];
    std::size_t widest = std::string(in_group(column) ? column.name : column.unit).size();
    if (!in_group(column)) widest = std::max(widest + 4, std::string(column.name).size());  // brackets, arrow
    for (const paper::Block& block : content.blocks)
      for (const paper::Row& row : block.rows) widest = std::max(widest, row.cells[c].text.size());
    figures += widest;
  }
  return name + figures;
}

/// So that it fits the text of an article of one column.
std::string text_size(const Content& content) {
  constexpr std::size_t kMostOfFootnotes = 60;
  return letters(content) <= kMostOfFootnotes ? "\\footnotesize\n\\setlength{\\tabcolsep}{3.5pt}\n"
                                              : "\\scriptsize\n\\setlength{\\tabcolsep}{3pt}\n";
}

std::string cell_text(const paper::Cell& cell) {
  if (cell.text == "-") return "--";
  std::string text = cell.text;
  const bool marked = text.back() == '*';
  if (marked) text.pop_back();
  if (text[0] == '<') text = "$<$" + text.substr(1);
  if (cell.best) text = "\\textbf{" + text + "}";
  return marked ? text + "\\rlap{$^{*}$}" : text;  // digits stay below each other
}

std::string body(const Content& content) {
  std::string text;
  const std::string span = std::to_string(content.columns.size() + 1);
  for (const paper::Block& block : content.blocks) {
    text += "\\midrule\n\\multicolumn{" + span + "}{@{}l}{\\emph{" + escaped(block.title) + "}} \\\\\n";
    for (const paper::Row& row : block.rows) {
      text += escaped(row.pipeline);
      for (const paper::Cell& cell : row.cells) text += " & " + cell_text(cell);
      text += " \\\\\n";
    }
  }
  return text;
}

}  // namespace

std::string latex_table(const Comparison& comparison, const Provenance& provenance) {
  const Content content = paper::content_of(comparison, provenance);
  std::string notes;
  for (const std::string& note : content.notes) notes += (notes.empty() ? "" : "\n") + escaped(note);
  return "% \\usepackage{booktabs} in the preamble, then \\input this file.\n"
         "\\begin{table*}\n\\centering\n\\caption{" +
         escaped(content.caption) + "}\n\\label{tab:dynfilter}\n\\smallskip\n" + text_size(content) +
         "\\begin{tabular}{@{}l" + std::string(content.columns.size(), 'r') + "@{}}\n\\toprule\n" +
         heads(content.columns) + body(content) +
         "\\bottomrule\n\\end{tabular}\n\n\\smallskip\n\\parbox{\\linewidth}{\\scriptsize\n" + notes +
         "}\n\\end{table*}\n";
}

}  // namespace dynfilter::eval
