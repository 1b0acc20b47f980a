// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <dynfilter/cluster/depth_split.hpp>
#include <dynfilter/config/field_table.hpp>
#include <dynfilter/config/parameters.hpp>
#include <dynfilter/core/frame_inputs.hpp>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/semantic/provider.hpp>
#include <memory>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace dynfilter {

/// Merges the instance masks of detections to one label image.
/// CV_8UC1, 0: no object, else class id + 1, at most 255; 1 for an unknown class.
/// Where masks overlap, the higher score wins. Masks of another size are skipped.
inline cv::Mat merged_masks(const std::vector<Detection>& detections, cv::Size image) {
  std::vector<const Detection*> order;
  for (const Detection& d : detections)
    if (d.mask.type() == CV_8UC1 && d.mask.size() == image) order.push_back(&d);
  std::stable_sort(order.begin(), order.end(),
                   [](const Detection* a, const Detection* b) { return a->score < b->score; });
  cv::Mat labels = cv::Mat::zeros(image, CV_8UC1);
  for (const Detection* d : order) labels.setTo(cv::Scalar(std::clamp(d->class_id, 0, 254) + 1), d->mask);
  return labels;
}

struct BoxMaskParams {
  std::vector<std::string> classes = moving_classes();
  static constexpr double kMinScore = 0.4;  ///< Smallest score of a box that gets a mask.
  /// Margin beyond each side of the box, as a share of its size, that the object may cover.
  static constexpr double kExpandShare = 0.05;
  /// Depth margin behind the nearer surface of the box that still belongs to the object.
  static constexpr double kMargin_m = 0.15;
  /// Largest depth difference between a part and the middle of the object.
  static constexpr double kMaxReach_m = 0.5;
  /// Relative depth step between neighbouring pixels that separates two surfaces.
  static constexpr double kMaxStepShare = 0.02;
  int close_px = 4;  ///< Radius of gaps that are closed. Not a key: code sets it.

  static const FieldTable<BoxMaskParams>& fields() {
    using P = BoxMaskParams;
    static const FieldTable<P> table{
        words("classes", &P::classes, "names of the classes with masks; empty: all classes"),
    };
    return table;
  }
};

/// Creates masks from boxes and a depth image: the person, without the wall behind. The depths of each box
/// are split into two surfaces (cluster/depth_split.hpp). A surface that is almost absent in the middle of
/// the box is an occluder and is excluded. The object's depth is the median of the nearer surface in the
/// middle of the box. The mask grows from there over pixels without a depth jump. It is limited to the
/// enlarged box and to the depth of the nearer surface + margin_m. A box without depth gets no mask. Surfaces
/// that touch the object without a jump are included within the box, such as the chair under a person. Cost:
/// linear in the pixels of the boxes, about 1 ms for a box of half the image.
class BoxMasks {
 public:
  explicit BoxMasks(BoxMaskParams params = BoxMaskParams()) : params_(std::move(params)) {
    check_parameters(params_, "box_masks");
  }

  /// Adds a mask (CV_8UC1, 255 inside) to each selected detection without one. `depth`: CV_32FC1 or CV_16UC1
  /// in units of `unit_m`, in the pixels of the boxes. Any other type adds no mask.
  void add(std::vector<Detection>& detections, const cv::Mat& depth, double unit_m);

 private:
  static constexpr int kMostOccluders = 3;

  float at(int x, int y) const {
    return depth_.type() == CV_32FC1 ? depth_.at<float>(y, x) * unit_m_
                                     : static_cast<float>(depth_.at<std::uint16_t>(y, x)) * unit_m_;
  }
  static bool valid(float z) { return z > 0 && std::isfinite(z); }

  cv::Rect pixels_of(const cv::Rect2f& box, double grow_share) const;

  /// Calls f(x, y, z) on a grid of at most 24 x 24 pixels with depth.
  template <class F>
  void sample(const cv::Rect& area, const F& f) const;
  cv::Mat mask_of(const cv::Rect2f& box);

  /// Far end of the nearest surface of the box behind `nearest_m`.
  float surface_end_m(const cv::Rect& area, float nearest_m);

  cv::Mat grown(const cv::Rect& seeds, const cv::Rect& area, float middle_m, float farthest_m);
  void close_gaps(cv::Mat& mask, const cv::Rect& area) const;

  BoxMaskParams params_;
  cv::Mat depth_;
  float unit_m_ = 1;
  std::vector<float> samples_;
  std::vector<cv::Point> open_;
};

/// A box detector that also creates masks from the depth image of the frame. It adds instance masks and, if
/// the detector has no label image, one merged from them. Pipelines with `semantic_mask` can therefore use
/// it. Without a depth image it returns the detector's result unchanged.
class BoxMaskProvider final : public SemanticProvider {
 public:
  /// `detector` finds the boxes; throws ConfigError for parameters out of range.
  BoxMaskProvider(std::unique_ptr<SemanticProvider> detector, BoxMaskParams params)
      : detector_(std::move(detector)), masks_(std::move(params)) {}

  std::string name() const override { return detector_->name(); }

  std::optional<SemanticResult> infer(const SemanticImage& image) override;

 private:
  std::unique_ptr<SemanticProvider> detector_;
  BoxMasks masks_;
};

inline void BoxMasks::add(std::vector<Detection>& detections, const cv::Mat& depth, double unit_m) {
  if (depth.empty() || (depth.type() != CV_32FC1 && depth.type() != CV_16UC1)) return;
  depth_ = depth;
  unit_m_ = static_cast<float>(unit_m);
  for (Detection& detection : detections) {
    const bool listed = params_.classes.empty() || std::find(params_.classes.begin(), params_.classes.end(),
                                                             detection.class_name) != params_.classes.end();
    if (listed && detection.mask.empty() && static_cast<double>(detection.score) >= BoxMaskParams::kMinScore)
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
    return grown(inner, pixels_of(box, BoxMaskParams::kExpandShare), *middle, farthest_m);
  }
  return {};
}

inline float BoxMasks::surface_end_m(const cv::Rect& area, float nearest_m) {
  samples_.clear();
  sample(area, [&](int, int, float z) {
    if (z > nearest_m) samples_.push_back(1 / z);
  });
  return static_cast<float>(nearer_surface_m(samples_) + BoxMaskParams::kMargin_m);
}

inline cv::Mat BoxMasks::grown(const cv::Rect& seeds, const cv::Rect& area, float middle_m,
                               float farthest_m) {
  cv::Mat mask = cv::Mat::zeros(depth_.size(), CV_8UC1);
  const auto reach_m = static_cast<float>(BoxMaskParams::kMaxReach_m);
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
    const float z = at(p.x, p.y), max_step_m = static_cast<float>(BoxMaskParams::kMaxStepShare) * z;
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

inline std::optional<SemanticResult> BoxMaskProvider::infer(const SemanticImage& image) {
  std::optional<SemanticResult> result = detector_->infer(image);
  if (!result || !result->detections || image.depth.empty() || image.depth.size() != image.pixels.size())
    return result;
  masks_.add(*result->detections, image.depth, image.depth_unit_m);
  if (!result->labels) result->labels = merged_masks(*result->detections, image.depth.size());
  return result;
}

}  // namespace dynfilter
