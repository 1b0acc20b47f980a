// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/io/text_lines.hpp>

#include <dynfilter/core/error.hpp>
#include <dynfilter/core/inline.hpp>
#include <fstream>
#include <system_error>
#include <utility>

namespace dynfilter::io {

DYNFILTER_INLINE std::vector<TextLine> read_text_lines(const std::filesystem::path& path) {
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

DYNFILTER_INLINE std::string at_line(const std::filesystem::path& path, int line) {
  return path.string() + ":" + std::to_string(line);
}

DYNFILTER_INLINE double number_at(const TextLine& line, std::size_t field,
                                  const std::filesystem::path& path) {
  const auto value = parse_number(line.fields[field]);
  if (!value) throw IoError(at_line(path, line.number) + ": '" + line.fields[field] + "' is not a number");
  return *value;
}

}  // namespace dynfilter::io
