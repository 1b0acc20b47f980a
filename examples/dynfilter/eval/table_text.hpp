// SPDX-License-Identifier: MIT
#pragma once

#include <string>

// Fields of tables for other programs.
namespace dynfilter::eval {

/// Quoted where CSV needs it.
inline std::string csv_field(const std::string& text) {
  if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

/// A cell of a Markdown table. Characters that Markdown or HTML would act on are shown as they are.
inline std::string markdown_cell(const std::string& text) {
  std::string cell;
  for (const char c : text) {
    if (c == '\n' || c == '\r') {
      cell += ' ';
      continue;
    }
    if (c == '<') {
      cell += "&lt;";
      continue;
    }
    if (std::string("|\\`*_[]").find(c) != std::string::npos) cell += '\\';
    cell += c;
  }
  return cell;
}

}  // namespace dynfilter::eval
