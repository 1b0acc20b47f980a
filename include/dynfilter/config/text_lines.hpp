// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <dynfilter/config/numbers.hpp>
#include <dynfilter/core/error.hpp>
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

/// The lines of a text file, without their line ends.
class LineReader {
 public:
  /// Throws IoError if the file cannot be read.
  explicit LineReader(std::filesystem::path path);

  /// False at the end. Throws IoError if the line has more than limits::kMaxLineBytes.
  bool next(std::string& line);

  /// Number of the last line, counted from 1.
  int number() const { return number_; }

 private:
  std::filesystem::path path_;
  std::ifstream in_;
  std::vector<char> buffer_;
  int number_ = 0;
};

/// Reads the lines with data. Skips blank lines and `#` comments. Throws IoError if the file cannot be read,
/// a line is too long, or there are more than limits::kMaxTextFields fields.
std::vector<TextLine> read_text_lines(const std::filesystem::path& path);

using dynfilter::parse_number;

/// `path:line` for messages.
std::string at_line(const std::filesystem::path& path, int line);

/// The number in an existing field. Throws IoError with file and line if it is none.
double number_at(const TextLine& line, std::size_t field, const std::filesystem::path& path);

}  // namespace dynfilter::io

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/config/detail/text_lines-inl.hpp>
#endif
