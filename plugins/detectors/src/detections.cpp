// SPDX-License-Identifier: MIT
#include <dynfilter/detectors/detections.hpp>

#include <algorithm>
#include <array>
#include <dynfilter/config/text_lines.hpp>
#include <dynfilter/core/error.hpp>
#include <dynfilter/core/limits.hpp>
#include <dynfilter/core/printable_text.hpp>
#include <map>
#include <opencv2/core.hpp>
#include <string>
#include <utility>

namespace dynfilter::io {

const std::vector<Detection>* DetectionTrack::at(double timestamp_s) const {
  constexpr double kSameStamp_s = 5e-4;
  auto next = std::lower_bound(images.begin(), images.end(), timestamp_s - kSameStamp_s,
                               [](const StampedDetections& a, double t) { return a.timestamp_s < t; });
  const StampedDetections* best = nullptr;
  double best_gap_s = kSameStamp_s;
  for (; next != images.end() && next->timestamp_s <= timestamp_s + kSameStamp_s; ++next) {
    const double gap_s = std::abs(next->timestamp_s - timestamp_s);
    if (gap_s <= best_gap_s) {
      best_gap_s = gap_s;
      best = &*next;
    }
  }
  return best ? &best->detections : nullptr;
}

namespace detail {

// Some class names contain blanks ("cell phone"), so numbers are counted from both ends.
inline Detection parse_detection(const TextLine& line, const std::filesystem::path& path) {
  const std::size_t n = line.fields.size();
  if (n < 8) {
    throw IoError(at_line(path, line.number) +
                  ": expected 'timestamp class_id class_name score x1 y1 x2 y2' or 'timestamp none', found " +
                  std::to_string(n) + " fields");
  }
  std::array<double, 5> tail{};  // score x1 y1 x2 y2
  for (std::size_t i = 0; i < 5; ++i) tail[i] = number_at(line, n - 5 + i, path);
  Detection d;
  const double id = number_at(line, 1, path);
  if (!(std::abs(id) < 1e9)) throw IoError(at_line(path, line.number) + ": the class id is not a number");
  d.class_id = static_cast<int>(id);
  for (std::size_t i = 2; i < n - 5; ++i) d.class_name += (i > 2 ? " " : "") + line.fields[i];
  d.class_name = without_controls(d.class_name);
  d.score = static_cast<float>(tail[0]);
  d.box = cv::Rect2f(cv::Point2f(static_cast<float>(tail[1]), static_cast<float>(tail[2])),
                     cv::Point2f(static_cast<float>(tail[3]), static_cast<float>(tail[4])));
  if (tail[3] < tail[1] || tail[4] < tail[2]) d.box.width = 0;  // cv::Rect_ would swap the corners
  return d;
}

}  // namespace detail

DetectionTrack read_detections(const std::filesystem::path& path) {
  std::map<double, std::vector<Detection>> by_time;
  DetectionTrack track;
  for (const TextLine& line : read_text_lines(path)) {
    const double stamp_s = number_at(line, 0, path);
    if (!std::isfinite(stamp_s))
      throw IoError(at_line(path, line.number) + ": the timestamp is not a number");
    std::vector<Detection>& of_image = by_time[stamp_s];
    if (line.fields.size() == 2 && line.fields[1] == "none") continue;
    const Detection d = detail::parse_detection(line, path);
    detail::usable(d) ? of_image.push_back(d) : void(++track.unusable);
    if (of_image.size() > limits::kMaxBoxes)
      throw IoError(at_line(path, line.number) + ": more than " + std::to_string(limits::kMaxBoxes) +
                    " boxes for one image");
  }
  for (auto& [stamp_s, detections] : by_time) track.images.push_back({stamp_s, std::move(detections)});
  return track;
}

}  // namespace dynfilter::io
