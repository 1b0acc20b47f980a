// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <dynfilter/core/error.hpp>
#include <dynfilter/core/numbers.hpp>
#include <filesystem>
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
std::vector<TextLine> read_text_lines(const std::filesystem::path& path);

using dynfilter::parse_number;

/// `path:line` for messages.
std::string at_line(const std::filesystem::path& path, int line);

/// The number in an existing field. Throws IoError with file and line if it is none.
double number_at(const TextLine& line, std::size_t field, const std::filesystem::path& path);

}  // namespace dynfilter::io

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/io/detail/text_lines-inl.hpp>
#endif
