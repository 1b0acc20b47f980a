// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/semantic/box_masks.hpp>

#include <algorithm>
#include <cstddef>
#include <dynfilter/cluster/depth_split.hpp>
#include <dynfilter/core/inline.hpp>
#include <dynfilter/config/parameters.hpp>
#include <dynfilter/semantic/merged_masks.hpp>

namespace dynfilter {

DYNFILTER_INLINE const FieldTable<BoxMaskParams>& BoxMaskParams::fields() {
  using P = BoxMaskParams;
  static const FieldTable<P> table{
      words("classes", &P::classes, "names of the classes with masks; empty: all classes"),
      real("min_score", &P::min_score, "", {0, 1}, "smallest score of a box that gets a mask"),
      real("expand_share", &P::expand_share, "", {0, 1},
           "margin beyond each side of the box, as a share of its size, that the object may cover"),
      real("margin_m", &P::margin_m, "m", {0, 10},
           "depth margin behind the nearer surface of the box that still belongs to the object"),
      real("max_reach_m", &P::max_reach_m, "m", {0, 10},
           "largest depth difference between a part and the middle of the object"),
      real("max_step_share", &P::max_step_share, "", {0, 1},
           "relative depth step between neighbouring pixels that separates two surfaces"),
      integer("close_px", &P::close_px, "px", {0, 50}, "radius of gaps that are closed"),
  };
  return table;
}

DYNFILTER_INLINE BoxMasks::BoxMasks(BoxMaskParams params) : params_(std::move(params)) {
  check_parameters(params_, "box_masks");
}

DYNFILTER_INLINE void BoxMasks::add(std::vector<Detection>& detections, const cv::Mat& depth, double unit_m) {
  if (depth.empty() || (depth.type() != CV_32FC1 && depth.type() != CV_16UC1)) return;
  depth_ = depth;
  unit_m_ = static_cast<float>(unit_m);
  for (Detection& detection : detections) {
    const bool listed = params_.classes.empty() || std::find(params_.classes.begin(), params_.classes.end(),
                                                             detection.class_name) != params_.classes.end();
    if (listed && detection.mask.empty() && static_cast<double>(detection.score) >= params_.min_score)
      detection.mask = mask_of(detection.box);
  }
}

inline cv::Rect BoxMasks::pixels_of(const cv::Rect2f& box, double grow_share) const {
  const double dx = grow_share * static_cast<double>(box.width),
               dy = grow_share * static_cast<double>(box.height);
  const auto side = [](double value, int size) {
    return static_cast<int>(std::clamp(value, 0.0, size + 0.0));
  };
  const double x = static_cast<double>(box.x), y = static_cast<double>(box.y);
  const int x0 = side(std::floor(x - dx), depth_.cols), y0 = side(std::floor(y - dy), depth_.rows);
  return {x0, y0, side(std::ceil(x + static_cast<double>(box.width) + dx), depth_.cols) - x0,
          side(std::ceil(y + static_cast<double>(box.height) + dy), depth_.rows) - y0};
}

template <class F>
void BoxMasks::sample(const cv::Rect& area, const F& f) const {
  constexpr int kGrid = 24;
  const int step_x = std::max(1, area.width / kGrid), step_y = std::max(1, area.height / kGrid);
  for (int y = area.y + step_y / 2; y < area.br().y; y += step_y)
    for (int x = area.x + step_x / 2; x < area.br().x; x += step_x)
      if (const float z = at(x, y); valid(z)) f(x, y, z);
}

inline cv::Mat BoxMasks::mask_of(const cv::Rect2f& box) {
  if (!(box.width > 0) || !(box.height > 0) || !std::isfinite(box.x + box.width) ||
      !std::isfinite(box.y + box.height))
    return {};
  const cv::Rect inner = pixels_of(box, -0.25);
  float nearest_m = 0;
  for (int surface = 0; surface < kMostOccluders; ++surface) {
    const float farthest_m = surface_end_m(pixels_of(box, 0), nearest_m);
    std::size_t all = 0;
    samples_.clear();
    sample(inner, [&](int, int, float z) {
      ++all;
      if (z > nearest_m && z <= farthest_m) samples_.push_back(z);
    });
    if (all == 0) return {};
    // A surface that is almost absent in the middle of the box is an occluder, not the object.
    if (4 * samples_.size() < all) {
      nearest_m = farthest_m;
      continue;
    }
    const auto middle = samples_.begin() + static_cast<std::ptrdiff_t>(samples_.size() / 2);
    std::nth_element(samples_.begin(), middle, samples_.end());
    return grown(inner, pixels_of(box, params_.expand_share), *middle, farthest_m);
  }
  return {};
}

inline float BoxMasks::surface_end_m(const cv::Rect& area, float nearest_m) {
  samples_.clear();
  sample(area, [&](int, int, float z) {
    if (z > nearest_m) samples_.push_back(1 / z);
  });
  return static_cast<float>(nearer_surface_m(samples_) + params_.margin_m);
}

inline cv::Mat BoxMasks::grown(const cv::Rect& seeds, const cv::Rect& area, float middle_m,
                               float farthest_m) {
  cv::Mat mask = cv::Mat::zeros(depth_.size(), CV_8UC1);
  const auto reach_m = static_cast<float>(params_.max_reach_m);
  const float from_m = middle_m - reach_m, to_m = std::min(middle_m + reach_m, farthest_m);
  open_.clear();
  const auto enter = [&](int x, int y) {
    mask.at<std::uint8_t>(y, x) = 255;
    open_.emplace_back(x, y);
  };
  sample(seeds, [&](int x, int y, float z) {
    if (std::abs(z - middle_m) <= 0.5F * reach_m && z <= to_m) enter(x, y);
  });
  constexpr int kSteps[4][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};
  while (!open_.empty()) {
    const cv::Point p = open_.back();
    open_.pop_back();
    const float z = at(p.x, p.y), max_step_m = static_cast<float>(params_.max_step_share) * z;
    for (const auto& [dx, dy] : kSteps) {
      const cv::Point q(p.x + dx, p.y + dy);
      if (!area.contains(q) || mask.at<std::uint8_t>(q) != 0) continue;
      const float there = at(q.x, q.y);
      if (there >= from_m && there <= to_m && valid(there) && std::abs(there - z) <= max_step_m)
        enter(q.x, q.y);
    }
  }
  close_gaps(mask, area);
  return mask;
}

inline void BoxMasks::close_gaps(cv::Mat& mask, const cv::Rect& area) const {
  if (params_.close_px == 0) return;
  const int size = 2 * params_.close_px + 1;
  cv::Mat part = mask(area);
  cv::morphologyEx(part, part, cv::MORPH_CLOSE, cv::getStructuringElement(cv::MORPH_ELLIPSE, {size, size}));
}

DYNFILTER_INLINE std::optional<SemanticResult> BoxMaskProvider::infer(const SemanticImage& image) {
  std::optional<SemanticResult> result = detector_->infer(image);
  if (!result || !result->detections || image.depth.empty() || image.depth.size() != image.pixels.size())
    return result;
  masks_.add(*result->detections, image.depth, image.depth_unit_m);
  if (!result->labels) result->labels = merged_masks(*result->detections, image.depth.size());
  return result;
}

}  // namespace dynfilter
