// SPDX-License-Identifier: MIT
#include "io/image_folder_index.hpp"

#include <fnmatch.h>

#include <algorithm>
#include <cmath>
#include <dynfilter/config/camera_file.hpp>
#include <dynfilter/config/numbers.hpp>
#include <dynfilter/config/text_lines.hpp>
#include <dynfilter/core/error.hpp>
#include <system_error>

namespace dynfilter::io::detail {

/// "left/", "images/" or "", the first that has images.
inline std::optional<std::string> image_subfolder(const std::filesystem::path& folder) {
  for (const char* name : {"left/", "images/", ""})
    if (!images_in(folder / name).empty()) return name;
  return std::nullopt;
}

/// The names as stamps; nothing unless each name is a stamp and they increase.
inline std::optional<std::vector<double>> stamps_in_names(const std::vector<std::string>& names) {
  constexpr double kLeastNanoseconds = 1e17, kLeastSeconds = 1e8;  // 1973, in each unit
  std::vector<double> stamps_s;
  for (const std::string& name : names) {
    const std::string stem = std::filesystem::path(name).stem().string();
    const auto number = parse_number(stem);
    if (!number || !std::isfinite(*number)) return std::nullopt;
    const bool fraction = stem.find('.') != std::string::npos;
    if (!fraction && *number < kLeastSeconds) return std::nullopt;  // a frame's number
    stamps_s.push_back(*number >= kLeastNanoseconds ? 1e-9 * *number : *number);
    if (stamps_s.size() > 1 && !(stamps_s.back() > stamps_s[stamps_s.size() - 2])) return std::nullopt;
  }
  return stamps_s;
}

inline std::vector<double> stamps_of_file(const std::filesystem::path& path, std::size_t images) {
  std::vector<double> stamps_s;
  for (const TextLine& line : read_text_lines(path)) {
    const double stamp_s = stamp_of(line, 0, path);
    if (!comes_later(stamp_s, stamps_s.empty() ? -1e300 : stamps_s.back(), line, path))
      throw IoError(at_line(path, line.number) + ": the timestamp is repeated");
    stamps_s.push_back(stamp_s);
  }
  if (stamps_s.size() != images)
    throw IoError(path.string() + ": " + counted(stamps_s.size(), "time", "times") + " for " +
                  counted(images, "image", "images"));
  return stamps_s;
}

inline std::vector<double> counted_stamps(std::size_t images, std::optional<double> rate_hz,
                                          std::vector<std::string>& notes) {
  constexpr double kUsual_hz = 30;
  if (!rate_hz)
    notes.emplace_back("no times.txt, no stamps in the images' names and no Camera.fps: played at 30 Hz");
  std::vector<double> stamps_s;
  for (std::size_t i = 0; i < images; ++i)
    stamps_s.push_back(static_cast<double>(i) / rate_hz.value_or(kUsual_hz));
  return stamps_s;
}

bool is_image_folder(const std::filesystem::path& folder) {
  return image_subfolder(folder).has_value();
}

inline std::optional<double> rate_in(const std::filesystem::path& folder) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(folder / "camera.yaml", error)) return std::nullopt;
  return read_camera(folder / "camera.yaml").rate_hz;
}

inline void add_images(const std::string& below, const std::vector<std::string>& names,
                       const std::vector<double>& stamps_s, SequenceIndex& index) {
  for (std::size_t i = 0; i < names.size(); ++i) {
    IndexedFrame frame;
    frame.timestamp_s = stamps_s[i];
    frame.image = below + names[i];
    index.frames.push_back(frame);
  }
  index.may_guess_camera = true;
}

SequenceIndex read_image_folder_index(const std::filesystem::path& folder, std::optional<double> rate_hz) {
  SequenceIndex index;
  const std::string below = *image_subfolder(folder);
  const std::vector<std::string> names = images_in(folder / below);
  std::error_code error;
  if (!rate_hz) rate_hz = rate_in(folder);
  const bool has_times = std::filesystem::is_regular_file(folder / "times.txt", error);
  std::optional<std::vector<double>> stamps_s;
  if (has_times) stamps_s = stamps_of_file(folder / "times.txt", names.size());
  if (!stamps_s) stamps_s = stamps_in_names(names);
  if (!stamps_s) stamps_s = counted_stamps(names.size(), rate_hz, index.notes);
  add_images(below, names, *stamps_s, index);
  if (below == "left/") add_right_images(folder, index);
  index.poses = folder / "groundtruth.txt";
  index.pose_format = TrajectoryFormat::Tum;
  return index;
}

SequenceIndex read_image_pattern_index(const std::filesystem::path& pattern, std::optional<double> rate_hz) {
  const std::filesystem::path folder = pattern.parent_path().empty() ? "." : pattern.parent_path();
  if (folder.string().find_first_of("*?[") != std::string::npos)
    throw IoError(pattern.string() + ": only the name of the file may have wildcards, not its folder's");
  SequenceIndex index;
  std::vector<std::string> names = images_in(folder);
  const std::string wanted = pattern.filename().string();
  names.erase(std::remove_if(names.begin(), names.end(),
                             [&](const std::string& name) {
                               return ::fnmatch(wanted.c_str(), name.c_str(), FNM_PERIOD) != 0;
                             }),
              names.end());
  if (names.empty())
    throw IoError(pattern.string() + ": no PNG, JPEG, PGM, PPM or BMP image fits this pattern");
  if (!rate_hz) rate_hz = rate_in(folder);
  std::optional<std::vector<double>> stamps_s = stamps_in_names(names);
  if (!stamps_s) stamps_s = counted_stamps(names.size(), rate_hz, index.notes);
  add_images("", names, *stamps_s, index);
  return index;
}

}  // namespace dynfilter::io::detail
