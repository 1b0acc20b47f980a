// SPDX-License-Identifier: MIT
#include "io/tum_index.hpp"

#include <cmath>
#include <dynfilter/config/text_lines.hpp>
#include <dynfilter/core/error.hpp>
#include <optional>
#include <system_error>

#include "io/association.hpp"

namespace dynfilter::io::detail {

struct StampedFile {
  double timestamp_s = 0;
  std::string file;  // relative to the sequence folder
};

inline std::vector<StampedFile> read_file_list(const std::filesystem::path& folder, const std::string& name,
                                               std::vector<std::string>& notes) {
  const std::filesystem::path path = folder / name;
  std::vector<StampedFile> files;
  std::size_t repeated = 0, missing = 0;
  double last_s = -1e300;
  for (const TextLine& line : read_text_lines(path)) {
    if (line.fields.size() < 2) throw IoError(at_line(path, line.number) + ": expected 'timestamp file'");
    const double timestamp_s = stamp_of(line, 0, path);
    std::error_code error;
    if (!comes_later(timestamp_s, last_s, line, path)) {
      ++repeated;
    } else if (!std::filesystem::is_regular_file(folder / line.fields[1], error)) {
      ++missing;
    } else {
      files.push_back({timestamp_s, line.fields[1]});
    }
    last_s = timestamp_s;
  }
  if (files.empty() && missing > 0) throw IoError(path.string() + ": none of the listed images exists");
  if (files.empty()) throw IoError(path.string() + ": lists no images");
  if (repeated > 0)
    notes.push_back(name + ": " + counted(repeated, "image", "images") +
                    " with a repeated timestamp left out");
  if (missing > 0)
    notes.push_back(name + ": " + counted(missing, "missing image", "missing images") + " left out");
  return files;
}

inline std::vector<double> stamps_of(const std::vector<StampedFile>& files) {
  std::vector<double> stamps_s;
  for (const StampedFile& file : files) stamps_s.push_back(file.timestamp_s);
  return stamps_s;
}

inline SequenceIndex index_from_lists(const std::filesystem::path& folder, double max_gap_s) {
  SequenceIndex index;
  const std::vector<StampedFile> colour = read_file_list(folder, "rgb.txt", index.notes);
  const std::vector<StampedFile> depth = read_file_list(folder, "depth.txt", index.notes);
  for (const StampedFile& file : colour) index.frames.push_back({file.timestamp_s, file.file, "", ""});
  for (const auto& [i, j] : associate(stamps_of(colour), stamps_of(depth), max_gap_s)) {
    index.frames[i].depth = depth[j].file;
  }
  return index;
}

// Some files have the depth columns first.
inline bool depth_comes_first(const TextLine& line) {
  return line.fields[1].rfind("depth", 0) == 0 && line.fields[3].rfind("depth", 0) != 0;
}

inline SequenceIndex index_from_associations(const std::filesystem::path& folder, const std::string& name,
                                             double max_gap_s) {
  const std::filesystem::path path = folder / name;
  SequenceIndex index;
  std::size_t repeated = 0, missing = 0;
  double last_s = -1e300;
  for (const TextLine& line : read_text_lines(path)) {
    if (line.fields.size() < 4) {
      throw IoError(at_line(path, line.number) + ": expected 'timestamp colour_file timestamp depth_file'");
    }
    const std::size_t colour_at = depth_comes_first(line) ? 2 : 0, depth_at = 2 - colour_at;
    const double timestamp_s = stamp_of(line, colour_at, path), depth_s = stamp_of(line, depth_at, path);
    const bool later = comes_later(timestamp_s, last_s, line, path);
    last_s = timestamp_s;
    std::error_code error;
    if (!later) {
      ++repeated;
    } else if (!std::filesystem::is_regular_file(folder / line.fields[colour_at + 1], error)) {
      ++missing;
    } else {
      const std::string& depth = line.fields[depth_at + 1];
      const bool has_depth = std::abs(timestamp_s - depth_s) < max_gap_s &&
                             std::filesystem::is_regular_file(folder / depth, error);
      index.frames.push_back({timestamp_s, line.fields[colour_at + 1], "", has_depth ? depth : ""});
    }
  }
  if (index.frames.empty() && missing > 0)
    throw IoError(path.string() + ": none of the listed images exists");
  if (index.frames.empty()) throw IoError(path.string() + ": lists no images");
  if (repeated > 0)
    index.notes.push_back(name + ": " + counted(repeated, "line", "lines") +
                          " with a repeated timestamp left out");
  if (missing > 0)
    index.notes.push_back(name + ": " + counted(missing, "missing image", "missing images") + " left out");
  return index;
}

inline std::optional<std::string> associations_file(const std::filesystem::path& folder) {
  for (const char* name : {"associations.txt", "association.txt", "associated.txt", "associate.txt"}) {
    std::error_code error;
    if (std::filesystem::is_regular_file(folder / name, error)) return name;
  }
  return std::nullopt;
}

// Notes how many frames of rgb.txt associations.txt omits, because frames are counted by index.
inline void note_unlisted(const std::filesystem::path& folder, const std::string& associations,
                          SequenceIndex& index) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(folder / "rgb.txt", error)) return;
  const std::size_t listed = read_text_lines(folder / "rgb.txt").size();
  if (listed <= index.frames.size()) return;
  index.notes.push_back(associations + ": " + counted(listed - index.frames.size(), "image", "images") +
                        " of rgb.txt not in it, left out");
}

bool is_tum_folder(const std::filesystem::path& folder) {
  std::error_code error;
  return associations_file(folder) || std::filesystem::exists(folder / "rgb.txt", error) ||
         std::filesystem::exists(folder / "depth.txt", error);
}

SequenceIndex read_tum_index(const std::filesystem::path& folder, double max_gap_s) {
  const auto associations = associations_file(folder);
  SequenceIndex index = associations ? index_from_associations(folder, *associations, max_gap_s)
                                     : index_from_lists(folder, max_gap_s);
  if (associations) note_unlisted(folder, *associations, index);
  if (associations && *associations != "associations.txt")
    index.notes.push_back("frames from " + *associations + ", not from rgb.txt and depth.txt");
  std::size_t without_depth = 0;
  for (const IndexedFrame& frame : index.frames) without_depth += frame.depth.empty();
  if (without_depth == index.frames.size()) {
    throw IoError(folder.string() + ": no frame has depth: no depth image within " +
                  std::to_string(max_gap_s).substr(0, 5) + " s of a colour image (" +
                  associations.value_or("rgb.txt, depth.txt") + ")");
  }
  if (without_depth > 0)
    index.notes.push_back(counted(without_depth, "frame has", "frames have") + " no depth image");
  add_right_images(folder, index);
  index.poses = folder / "groundtruth.txt";
  index.pose_format = TrajectoryFormat::Tum;
  return index;
}

}  // namespace dynfilter::io::detail
