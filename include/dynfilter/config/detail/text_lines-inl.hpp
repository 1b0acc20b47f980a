// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/config/text_lines.hpp>

#include <dynfilter/core/inline.hpp>
#include <dynfilter/core/limits.hpp>
#include <ios>
#include <system_error>
#include <utility>

namespace dynfilter::io {

DYNFILTER_INLINE LineReader::LineReader(std::filesystem::path path)
    : path_(std::move(path)), buffer_(limits::kMaxLineBytes + 1) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path_, error)) throw IoError(path_.string() + ": no such file");
  in_.open(path_);
  if (!in_) throw IoError(path_.string() + ": cannot be read");
}

DYNFILTER_INLINE bool LineReader::next(std::string& line) {
  in_.getline(buffer_.data(), static_cast<std::streamsize>(buffer_.size()));
  auto size = static_cast<std::size_t>(in_.gcount());
  ++number_;
  if (in_.fail()) {
    if (size == 0 || in_.eof()) return false;
    throw IoError(at_line(path_, number_) + ": has more than " + std::to_string(limits::kMaxLineBytes) +
                  " bytes");
  }
  if (!in_.eof()) --size;  // the line end counts
  line.assign(buffer_.data(), size);
  return true;
}

DYNFILTER_INLINE std::vector<TextLine> read_text_lines(const std::filesystem::path& path) {
  LineReader reader(path);
  std::vector<TextLine> lines;
  std::size_t fields = 0;
  for (std::string text; reader.next(text);) {
    TextLine line{reader.number(), {}, text.find(',') != std::string::npos};
    constexpr const char* kSeparators = " \t,\r";
    for (std::size_t begin = text.find_first_not_of(kSeparators); begin != std::string::npos;) {
      const std::size_t end = text.find_first_of(kSeparators, begin);
      if (++fields > limits::kMaxTextFields)
        throw IoError(at_line(path, line.number) + ": more than " + std::to_string(limits::kMaxTextFields) +
                      " fields");
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
