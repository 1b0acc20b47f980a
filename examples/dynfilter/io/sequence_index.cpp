// SPDX-License-Identifier: MIT
#include "io/sequence_index.hpp"

#include <algorithm>
#include <cmath>
#include <dynfilter/config/numbers.hpp>
#include <dynfilter/config/text_lines.hpp>
#include <dynfilter/core/error.hpp>
#include <system_error>

namespace dynfilter::io::detail {

std::string counted(std::size_t n, const std::string& one, const std::string& many) {
  return std::to_string(n) + " " + (n == 1 ? one : many);
}

double stamp_of(const TextLine& line, std::size_t field, const std::filesystem::path& path) {
  const auto value = parse_number(line.fields[field]);
  if (!value || !std::isfinite(*value)) {
    throw IoError(at_line(path, line.number) + ": '" + line.fields[field] + "' is not a timestamp");
  }
  return *value;
}

bool comes_later(double timestamp_s, double last_s, const TextLine& line, const std::filesystem::path& path) {
  if (timestamp_s < last_s) {
    throw IoError(at_line(path, line.number) + ": timestamps out of order: " + line.fields[0] +
                  " is earlier than the line before");
  }
  return timestamp_s > last_s;
}

/// Digits compare as numbers; names that differ in leading zeros only, as text.
static bool natural_order(const std::string& a, const std::string& b) {
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  const auto number_at = [&](const std::string& text, std::size_t& at) {
    const std::size_t from = std::min(text.find_first_not_of('0', at), text.size());
    for (at = from; at < text.size() && is_digit(text[at]);) ++at;
    return text.substr(from, at - from);
  };
  std::size_t i = 0, j = 0;
  while (i < a.size() && j < b.size()) {
    if (is_digit(a[i]) && is_digit(b[j])) {
      const std::string x = number_at(a, i), y = number_at(b, j);
      if (x.size() != y.size()) return x.size() < y.size();
      if (x != y) return x < y;
    } else if (a[i] != b[j]) {
      return a[i] < b[j];
    } else {
      ++i, ++j;
    }
  }
  return a.size() - i != b.size() - j ? a.size() - i < b.size() - j : a < b;
}

std::vector<std::string> images_in(const std::filesystem::path& folder) {
  static constexpr const char* kSuffixes[] = {".png", ".jpg", ".jpeg", ".pgm", ".ppm", ".bmp"};
  std::vector<std::string> names;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    const std::string suffix = entry.path().extension().string();
    const bool is_image =
        std::any_of(std::begin(kSuffixes), std::end(kSuffixes), [&](const char* s) { return suffix == s; });
    if (is_image) names.push_back(entry.path().filename().string());
  }
  std::sort(names.begin(), names.end(), natural_order);
  return names;
}

void add_right_images(const std::filesystem::path& folder, SequenceIndex& index) {
  std::error_code error;
  if (!std::filesystem::is_directory(folder / "right", error)) return;
  std::size_t missing = 0;
  for (IndexedFrame& frame : index.frames) {
    const std::string file = "right/" + std::filesystem::path(frame.image).filename().string();
    if (std::filesystem::is_regular_file(folder / file, error))
      frame.right = file;
    else
      ++missing;
  }
  if (missing == index.frames.size())
    throw IoError((folder / "right").string() + ": no image is named as one of the left camera");
  if (missing > 0) index.notes.push_back(counted(missing, "frame has", "frames have") + " no right image");
}

}  // namespace dynfilter::io::detail
