// SPDX-License-Identifier: MIT
#pragma once

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <sstream>
#include <string>

namespace dynfilter::command {

/// Columns of the terminal on standard output; 80 for a file or a pipe.
/// The environment variable COLUMNS overrides both.
inline std::size_t text_columns() {
  long columns = 80;
  winsize window{};
  if (isatty(STDOUT_FILENO) != 0 && ioctl(STDOUT_FILENO, TIOCGWINSZ, &window) == 0 && window.ws_col > 0)
    columns = window.ws_col;
  if (const char* set = std::getenv("COLUMNS"))
    if (const long asked = std::strtol(set, nullptr, 10); asked > 0) columns = asked;
  return static_cast<std::size_t>(std::clamp(columns, 40L, 1000L));
}

/// Number of characters of UTF-8 text.
inline std::size_t letters(const std::string& text) {
  return static_cast<std::size_t>(std::count_if(
      text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U; }));
}

/// Wraps a text at `columns` and indents each line by `indent` blanks.
/// Line breaks in the text count as blanks, and empty lines remain.
/// The result ends with a line break; "" for a text without words.
inline std::string wrapped(const std::string& text, std::size_t columns, std::size_t indent = 0) {
  const std::string margin(indent, ' ');
  std::string result;
  std::istringstream lines(text);
  std::string paragraph;
  const auto flush = [&] {
    std::istringstream words(paragraph);
    std::string line;
    for (std::string word; words >> word;) {
      if (!line.empty() && indent + letters(line) + 1 + letters(word) > columns) {
        result += margin + line + "\n";
        line.clear();
      }
      line += (line.empty() ? "" : " ") + word;
    }
    if (!line.empty()) result += margin + line + "\n";
    paragraph.clear();
  };
  for (std::string line; std::getline(lines, line);) {
    if (line.find_first_not_of(' ') == std::string::npos) {
      flush();
      if (!result.empty()) result += "\n";
    }
    paragraph += line + " ";
  }
  flush();
  return result;
}

}  // namespace dynfilter::command
