// SPDX-License-Identifier: MIT
#include "io/point_tracks.hpp"

#include <algorithm>
#include <bitset>
#include <cmath>
#include <dynfilter/config/numbers.hpp>
#include <dynfilter/config/text_lines.hpp>
#include <dynfilter/core/error.hpp>
#include <numeric>
#include <opencv2/core.hpp>
#include <optional>

namespace dynfilter::io {

bool PointTracks::visible(int point, int frame) const {
  const cv::Point2f& p = at(point, frame);
  return std::isfinite(p.x) && std::isfinite(p.y);
}

int PointTracks::last_visible(int point) const {
  for (int f = frames - 1; f >= 0; --f)
    if (visible(point, f)) return f;
  return -1;
}

namespace detail {

inline std::vector<std::string> words_of_comment(const std::string& line) {
  std::vector<std::string> words;
  constexpr const char* kSeparators = " \t\r#";
  for (std::size_t begin = line.find_first_not_of(kSeparators); begin != std::string::npos;) {
    const std::size_t end = line.find_first_of(kSeparators, begin);
    words.push_back(line.substr(begin, end - begin));
    begin = line.find_first_not_of(kSeparators, end);
  }
  return words;
}

inline std::optional<int> whole_number(const std::string& text, int min, int max) {
  const std::optional<double> value = parse_number(text);
  if (!value || !(*value >= min && *value <= max) || *value != std::floor(*value)) return std::nullopt;
  return static_cast<int>(*value);
}

/// Parses the header `# points P frames F width W height H` at any place among the comments.
inline bool read_track_header(const std::vector<std::string>& words, PointTracks& tracks) {
  if (words.size() < 8 || words[0] != "points" || words[2] != "frames" || words[4] != "width" ||
      words[6] != "height")
    return false;
  const auto points = whole_number(words[1], 1, 10'000'000), frames = whole_number(words[3], 1, 1'000'000),
             width = whole_number(words[5], 1, 1'000'000), height = whole_number(words[7], 1, 1'000'000);
  if (!points || !frames || !width || !height) return false;
  tracks.points = *points, tracks.frames = *frames, tracks.width_px = *width, tracks.height_px = *height;
  return true;
}

inline void read_track_comments(const std::filesystem::path& path, PointTracks& tracks) {
  LineReader reader(path);
  bool found = false;
  for (std::string line; reader.next(line) && !line.empty() && line[0] == '#';) {
    const std::vector<std::string> words = words_of_comment(line);
    if (tracks.title.empty() && !words.empty()) tracks.title = words[0];
    found = found || read_track_header(words, tracks);
  }
  if (!found) throw IoError(path.string() + ": expected the header '# points P frames F width W height H'");
}

}  // namespace detail

PointTracks read_point_tracks(const std::filesystem::path& path) {
  const std::vector<TextLine> lines = read_text_lines(path);
  PointTracks tracks;
  detail::read_track_comments(path, tracks);
  if (lines.size() != static_cast<std::size_t>(tracks.points))
    throw IoError(path.string() + ": the header says " + std::to_string(tracks.points) +
                  " points, there are " + std::to_string(lines.size()));
  const std::size_t expected = 1 + 2 * static_cast<std::size_t>(tracks.frames);
  for (const TextLine& line : lines) {
    if (line.fields.size() != expected)
      throw IoError(at_line(path, line.number) + ": expected a label and " + std::to_string(tracks.frames) +
                    " times 'x y', found " + std::to_string(line.fields.size()) + " fields");
    const auto label = detail::whole_number(line.fields[0], 0, 1'000'000);
    if (!label)
      throw IoError(at_line(path, line.number) + ": the label '" + line.fields[0] +
                    "' is not a whole number");
    tracks.label.push_back(*label);
    for (std::size_t f = 1; f < expected; f += 2)
      tracks.px.emplace_back(static_cast<float>(number_at(line, f, path)),
                             static_cast<float>(number_at(line, f + 1, path)));
  }
  return tracks;
}

namespace detail {

/// How far a label's points get over the image, and how many they are.
struct LabelSpread {
  static constexpr int kCells = 8;  ///< per side of the image

  int label = 0, points = 0;
  std::bitset<std::size_t{kCells} * kCells> seen;

  bool wider_than(const LabelSpread& other) const {
    return seen.count() != other.seen.count() ? seen.count() > other.seen.count() : points > other.points;
  }
  void add(const PointTracks& tracks, int point) {
    ++points;
    for (int f = 0; f < tracks.frames; ++f) {
      if (!tracks.visible(point, f)) continue;
      const cv::Point2f& px = tracks.at(point, f);
      seen.set(cell(px.y, tracks.height_px) * kCells + cell(px.x, tracks.width_px));
    }
  }
  static std::size_t cell(float at_px, int size_px) {
    return static_cast<std::size_t>(
        std::clamp(at_px / static_cast<float>(size_px) * kCells, 0.0F, kCells - 1.0F));
  }
};

}  // namespace detail

int widest_label(const PointTracks& tracks) {
  std::vector<int> by_label(static_cast<std::size_t>(tracks.points));
  std::iota(by_label.begin(), by_label.end(), 0);
  const auto label = [&](int point) { return tracks.label[static_cast<std::size_t>(point)]; };
  std::sort(by_label.begin(), by_label.end(), [&](int a, int b) { return label(a) < label(b); });
  detail::LabelSpread widest;
  for (std::size_t k = 0; k < by_label.size();) {
    detail::LabelSpread spread;
    spread.label = label(by_label[k]);
    for (; k < by_label.size() && label(by_label[k]) == spread.label; ++k) spread.add(tracks, by_label[k]);
    if (spread.wider_than(widest)) widest = spread;
  }
  return widest.label;
}

}  // namespace dynfilter::io
