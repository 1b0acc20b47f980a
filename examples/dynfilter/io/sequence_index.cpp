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
  std::sort(names.begin(), names.end());
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
