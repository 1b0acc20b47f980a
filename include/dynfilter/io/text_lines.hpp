// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/error.hpp>
#include <dynfilter/core/numbers.hpp>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace dynfilter::io {

/// One line of a TUM-style text file, split at blanks, tabs and commas.
struct TextLine {
  int number = 0;  ///< counted from 1
  std::vector<std::string> fields;
  bool has_commas = false;
};

/// Reads the lines with data. Skips blank lines and `#` comments.
/// Throws IoError if the file cannot be read.
inline std::vector<TextLine> read_text_lines(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) throw IoError(path.string() + ": no such file");
  std::ifstream in(path);
  if (!in) throw IoError(path.string() + ": cannot be read");
  std::vector<TextLine> lines;
  std::string text;
  for (int number = 1; std::getline(in, text); ++number) {
    TextLine line{number, {}, text.find(',') != std::string::npos};
    constexpr const char* kSeparators = " \t,\r";
    for (std::size_t begin = text.find_first_not_of(kSeparators); begin != std::string::npos;) {
      const std::size_t end = text.find_first_of(kSeparators, begin);
      line.fields.push_back(text.substr(begin, end - begin));
      begin = text.find_first_not_of(kSeparators, end);
    }
    if (!line.fields.empty() && line.fields[0][0] != '#') lines.push_back(std::move(line));
  }
  return lines;
}

using dynfilter::parse_number;

/// `path:line` for messages.
inline std::string at_line(const std::filesystem::path& path, int line) {
  return path.string() + ":" + std::to_string(line);
}

/// The number in an existing field. Throws IoError with file and line if it is none.
inline double number_at(const TextLine& line, std::size_t field, const std::filesystem::path& path) {
  const auto value = parse_number(line.fields[field]);
  if (!value) throw IoError(at_line(path, line.number) + ": '" + line.fields[field] + "' is not a number");
  return *value;
}

}  // namespace dynfilter::io
