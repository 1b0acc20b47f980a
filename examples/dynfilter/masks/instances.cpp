// SPDX-License-Identifier: MIT
#include "masks/instances.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <dynfilter/semantic/box_masks.hpp>
#include <map>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <string>
#include <utility>

namespace dynfilter::masks {
namespace {

/// Smaller regions have no features to vote with.
constexpr int kLeastArea_px = 64;
/// A region belongs to a box whose outline it shares at least this much.
constexpr double kSameOutline_iou = 0.6;
/// A region reaches into a box if this share of it does.
constexpr double kReaches_share = 0.15;

/// A connected region of one label.
struct Region {
  int label = 0;
  cv::Mat mask;  ///< of the size of `box`
  cv::Rect box;
  int area = 0;
};

std::vector<Region> regions_of_label(const cv::Mat& labels, int label) {
  cv::Mat numbered, statistics, middles;
  const int count =
      cv::connectedComponentsWithStats(labels == label, numbered, statistics, middles, 8, CV_32S);
  std::vector<Region> regions;
  for (int k = 1; k < count; ++k) {
    const int* s = statistics.ptr<int>(k);
    if (s[cv::CC_STAT_AREA] < kLeastArea_px) continue;
    const cv::Rect box(s[cv::CC_STAT_LEFT], s[cv::CC_STAT_TOP], s[cv::CC_STAT_WIDTH], s[cv::CC_STAT_HEIGHT]);
    regions.push_back({label, numbered(box) == k, box, s[cv::CC_STAT_AREA]});
  }
  return regions;
}

std::vector<Region> regions_of(const cv::Mat& labels) {
  std::vector<bool> there(256, false);
  for (int y = 0; y < labels.rows; ++y)
    for (int x = 0; x < labels.cols; ++x) there[labels.at<std::uint8_t>(y, x)] = true;
  std::vector<Region> regions;
  for (int label = 1; label < 256; ++label) {
    if (!there[static_cast<std::size_t>(label)]) continue;
    for (Region& region : regions_of_label(labels, label)) regions.push_back(std::move(region));
  }
  return regions;
}

cv::Rect pixels_of(const cv::Rect2f& box, cv::Size image) {
  const cv::Point from(cvFloor(box.x), cvFloor(box.y)), to(cvCeil(box.br().x), cvCeil(box.br().y));
  return cv::Rect(from, to) & cv::Rect({0, 0}, image);
}

double iou(const cv::Rect& a, const cv::Rect& b) {
  const double both = (a & b).area(), either = a.area() + b.area() - both;
  return either > 0 ? both / either : 0;
}

/// The box whose outline is that of `area`.
std::optional<std::size_t> box_around(const cv::Rect& area, const std::vector<cv::Rect>& boxes) {
  std::size_t best = 0;
  for (std::size_t i = 1; i < boxes.size(); ++i)
    if (iou(area, boxes[i]) > iou(area, boxes[best])) best = i;
  if (boxes.empty() || iou(area, boxes[best]) < kSameOutline_iou) return std::nullopt;
  return best;
}

/// Boxes that a region belongs to. A box around all regions of its label says that the label is one object.
/// Without it, that around the region counts, else all that it reaches into.
std::vector<std::size_t> boxes_of(const Region& region, const cv::Rect& label_box,
                                  const std::vector<cv::Rect>& boxes) {
  if (const auto box = box_around(label_box, boxes)) return {*box};
  if (const auto box = box_around(region.box, boxes)) return {*box};
  std::vector<std::size_t> reached;
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    const cv::Rect both = boxes[i] & region.box;
    if (!both.empty() &&
        cv::countNonZero(region.mask(both - region.box.tl())) >= kReaches_share * region.area)
      reached.push_back(i);
  }
  return reached;
}

/// Distance from the middle of a box; 1 at its sides.
double distance_in(const cv::Rect& box, cv::Point p) {
  return std::max(std::abs(2.0 * (p.x - box.x) / box.width - 1),
                  std::abs(2.0 * (p.y - box.y) / box.height - 1));
}

/// Gives each pixel of the region to the box whose middle is nearest, in units of the box.
/// A region of one box stays whole: the box's sides are less exact than the outline.
void share_out(const Region& region, const std::vector<std::size_t>& owners,
               const std::vector<cv::Rect>& boxes, std::vector<cv::Mat>& masks) {
  for (int y = 0; y < region.mask.rows; ++y) {
    for (int x = 0; x < region.mask.cols; ++x) {
      if (region.mask.at<std::uint8_t>(y, x) == 0) continue;
      const cv::Point p = cv::Point(x, y) + region.box.tl();
      const auto nearer = [&](std::size_t a, std::size_t b) {
        return distance_in(boxes[a], p) < distance_in(boxes[b], p);
      };
      masks[*std::min_element(owners.begin(), owners.end(), nearer)].at<std::uint8_t>(p) = 255;
    }
  }
}

void add_labelled(const cv::Mat& labels, const std::vector<cv::Rect>& boxes, std::vector<cv::Mat>& masks) {
  const std::vector<Region> regions = regions_of(labels);
  std::map<int, cv::Rect> label_boxes;
  for (const Region& region : regions) label_boxes[region.label] |= region.box;
  for (const Region& region : regions) {
    const std::vector<std::size_t> owners = boxes_of(region, label_boxes[region.label], boxes);
    if (!owners.empty()) share_out(region, owners, boxes, masks);
  }
}

std::vector<Instance> from_labels(const cv::Mat& labels) {
  std::vector<Instance> found;
  for (const Region& region : regions_of(labels))
    found.push_back({RunMask(region.mask, region.box.tl()), "label " + std::to_string(region.label)});
  return found;
}

std::vector<Instance> from_boxes(const Semantics& seen, const cv::Mat& labels, cv::Size image) {
  std::vector<Detection> detections = *seen.detections;
  std::vector<cv::Rect> boxes;
  std::vector<cv::Mat> masks;
  for (const Detection& d : detections) {
    boxes.push_back(pixels_of(d.box, image));
    const bool own = d.mask.type() == CV_8UC1 && d.mask.size() == image;
    masks.push_back(own ? d.mask.clone() : cv::Mat::zeros(image, CV_8UC1));
  }
  const bool have_own =
      std::any_of(detections.begin(), detections.end(), [](const Detection& d) { return !d.mask.empty(); });
  if (!labels.empty() && !have_own) add_labelled(labels, boxes, masks);
  BoxMaskParams every_class;
  every_class.classes.clear();
  BoxMasks by_depth(every_class);
  if (seen.depth.size() == image) by_depth.add(detections, seen.depth, seen.depth_unit_m);
  std::vector<Instance> found;
  for (std::size_t i = 0; i < detections.size(); ++i) {
    RunMask mask(masks[i]);
    if (mask.area() < kLeastArea_px && !detections[i].mask.empty()) mask = RunMask(detections[i].mask);
    if (mask.area() >= kLeastArea_px) found.push_back({std::move(mask), detections[i].class_name});
  }
  return found;
}

}  // namespace

std::vector<Instance> instances_of(const Semantics& seen, cv::Size image) {
  cv::Mat labels = seen.labels;
  if (!labels.empty() && labels.size() != image) cv::resize(labels, labels, image, 0, 0, cv::INTER_NEAREST);
  if (seen.detections != nullptr) return from_boxes(seen, labels, image);
  return labels.empty() ? std::vector<Instance>() : from_labels(labels);
}

}  // namespace dynfilter::masks
