// SPDX-License-Identifier: MIT
#include "masks/run_mask.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace dynfilter::masks {

RunMask::RunMask(const cv::Mat& mask, cv::Point offset) {
  for (int y = 0; y < mask.rows; ++y) {
    const auto* row = mask.ptr<std::uint8_t>(y);
    for (int x = 0; x < mask.cols;) {
      if (row[x] == 0) {
        ++x;
        continue;
      }
      const int from = x;
      while (x < mask.cols && row[x] != 0) ++x;
      runs_.push_back({static_cast<std::int16_t>(y + offset.y), static_cast<std::int16_t>(from + offset.x),
                       static_cast<std::int16_t>(x + offset.x)});
      area_ += x - from;
      const cv::Rect run(from + offset.x, y + offset.y, x - from, 1);
      box_ = box_.empty() ? run : box_ | run;
    }
  }
}

bool RunMask::contains(cv::Point pixel) const {
  if (!box_.contains(pixel)) return false;
  // The first run that ends behind the pixel.
  const auto found = std::partition_point(runs_.begin(), runs_.end(), [&](const Run& r) {
    return r.y < pixel.y || (r.y == pixel.y && r.to <= pixel.x);
  });
  return found != runs_.end() && found->y == pixel.y && found->from <= pixel.x;
}

int RunMask::overlap(const RunMask& other) const {
  if ((box_ & other.box_).empty()) return 0;
  int shared = 0;
  std::size_t i = 0, j = 0;
  while (i < runs_.size() && j < other.runs_.size()) {
    const Run &a = runs_[i], &b = other.runs_[j];
    if (a.y == b.y) shared += std::max(0, std::min(a.to, b.to) - std::max(a.from, b.from));
    const bool a_ends_first = a.y < b.y || (a.y == b.y && a.to <= b.to);
    a_ends_first ? ++i : ++j;
  }
  return shared;
}

double RunMask::intersection_over_union(const RunMask& other) const {
  const int shared = overlap(other), either = area_ + other.area_ - shared;
  return either > 0 ? static_cast<double>(shared) / either : 0;
}

void RunMask::paint(cv::Mat& image, std::uint8_t value) const {
  for (const Run& run : runs_) {
    if (run.y < 0 || run.y >= image.rows) continue;
    const int from = std::max<int>(run.from, 0), to = std::min<int>(run.to, image.cols);
    if (from < to)
      std::fill(image.ptr<std::uint8_t>(run.y) + from, image.ptr<std::uint8_t>(run.y) + to, value);
  }
}

RunMask RunMask::moved(cv::Point2f by_px, float scale, cv::Size image) const {
  if (empty()) return {};
  cv::Mat crop = cv::Mat::zeros(box_.size(), CV_8UC1);
  for (const Run& run : runs_)
    std::fill(crop.ptr<std::uint8_t>(run.y - box_.y) + (run.from - box_.x),
              crop.ptr<std::uint8_t>(run.y - box_.y) + (run.to - box_.x), std::uint8_t{255});
  const cv::Size size(std::max(1, cvRound(static_cast<float>(box_.width) * scale)),
                      std::max(1, cvRound(static_cast<float>(box_.height) * scale)));
  cv::resize(crop, crop, size, 0, 0, cv::INTER_NEAREST);
  const cv::Point2f middle(static_cast<float>(box_.x) + static_cast<float>(box_.width) / 2,
                           static_cast<float>(box_.y) + static_cast<float>(box_.height) / 2);
  const cv::Point corner(cvRound(middle.x + by_px.x - static_cast<float>(size.width) / 2),
                         cvRound(middle.y + by_px.y - static_cast<float>(size.height) / 2));
  const cv::Rect inside = cv::Rect(corner, size) & cv::Rect({0, 0}, image);
  return inside.empty() ? RunMask() : RunMask(crop(inside - corner), inside.tl());
}

}  // namespace dynfilter::masks
