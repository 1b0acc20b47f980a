// SPDX-License-Identifier: MIT
#include "render/detector_model.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <opencv2/core.hpp>

namespace dynfilter::render {

std::vector<cv::Rect> visible_boxes(const cv::Mat& instance, std::size_t objects, int smallest_px) {
  struct Extent {
    int x0 = 1 << 20, y0 = 1 << 20, x1 = -1, y1 = -1, area = 0;
  };
  std::vector<Extent> extents(objects + 1);
  for (int y = 0; y < instance.rows; ++y) {
    const auto* row = instance.ptr<std::uint16_t>(y);
    for (int x = 0; x < instance.cols; ++x) {
      if (row[x] == 0) continue;
      Extent& e = extents[row[x]];
      e.x0 = std::min(e.x0, x), e.x1 = std::max(e.x1, x);
      e.y0 = std::min(e.y0, y), e.y1 = std::max(e.y1, y);
      ++e.area;
    }
  }
  std::vector<cv::Rect> boxes(objects);
  for (std::size_t i = 0; i < objects; ++i) {
    const Extent& e = extents[i + 1];
    if (e.area >= smallest_px) boxes[i] = {e.x0, e.y0, e.x1 - e.x0 + 1, e.y1 - e.y0 + 1};
  }
  return boxes;
}

float intersection_over_union(const cv::Rect2f& a, const cv::Rect2f& b) {
  const float both = (a & b).area();
  return both > 0 ? both / (a.area() + b.area() - both) : 0.0F;
}

std::vector<Detection> DetectorModel::detect(const cv::Mat& instance, const std::vector<Detectable>& objects,
                                             Random& random) const {
  const std::vector<cv::Rect> boxes = visible_boxes(instance, objects.size(), faults_.smallest_px);
  std::vector<Detection> found;
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    if (boxes[i].area() > 0)
      found.push_back({cv::Rect2f(boxes[i]), objects[i].class_id, objects[i].class_name, 0.0F, -1, {}});
  }
  merge_people(found, random);
  std::vector<Detection> out;
  for (Detection& d : found) {
    const bool missed = random.chance(faults_.missed_share);
    disturb(d, instance.size(), random);
    if (!missed && d.box.width > 3 && d.box.height > 3) out.push_back(d);
  }
  std::stable_sort(out.begin(), out.end(),
                   [](const Detection& a, const Detection& b) { return a.score > b.score; });
  return out;
}

inline void DetectorModel::merge_people(std::vector<Detection>& found, Random& random) const {
  for (std::size_t i = 0; i < found.size(); ++i) {
    for (std::size_t j = i + 1; j < found.size(); ++j) {
      if (found[i].class_name != "person" || found[j].class_name != "person") continue;
      if (intersection_over_union(found[i].box, found[j].box) < faults_.merge_above_iou ||
          !random.chance(faults_.merged_share))
        continue;
      found[i].box |= found[j].box;
      found.erase(found.begin() + static_cast<std::ptrdiff_t>(j));
      return;
    }
  }
}

inline void DetectorModel::disturb(Detection& d, cv::Size picture, Random& random) const {
  const auto jitter = [&](float side) {
    return static_cast<float>(std::min(2.5, std::max(-2.5, random.gaussian())) * faults_.box_jitter) * side;
  };
  const float x0 = d.box.x + jitter(d.box.width), x1 = d.box.br().x + jitter(d.box.width);
  const float y0 = d.box.y + jitter(d.box.height), y1 = d.box.br().y + jitter(d.box.height);
  d.box = cv::Rect2f({x0, y0}, cv::Point2f(x1, y1)) &
          cv::Rect2f(0, 0, static_cast<float>(picture.width), static_cast<float>(picture.height));
  const double sure =
      0.93 - 0.35 * std::exp(-d.box.area() / 2500.0) + faults_.score_noise * random.gaussian();
  d.score = static_cast<float>(std::min(0.99, std::max(0.26, sure)));
}

}  // namespace dynfilter::render
