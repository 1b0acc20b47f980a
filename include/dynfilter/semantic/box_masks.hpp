// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstdint>
#include <dynfilter/core/detection.hpp>
#include <dynfilter/core/error.hpp>
#include <dynfilter/config/field_table.hpp>
#include <dynfilter/semantic/provider.hpp>
#include <memory>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace dynfilter {

struct BoxMaskParams {
  std::vector<std::string> classes = moving_classes();
  double min_score = 0.4;
  double expand_share = 0.05;
  double margin_m = 0.15;
  double max_reach_m = 0.5;
  double max_step_share = 0.02;
  int close_px = 4;

  static const FieldTable<BoxMaskParams>& fields();
};

/// Creates masks from boxes and a depth image: the person, without the wall behind.
/// The depths of each box are split into two surfaces (cluster/depth_split.hpp).
/// A surface that is almost absent in the middle of the box is an occluder and is excluded.
/// The object's depth is the median of the nearer surface in the middle of the box.
/// The mask grows from there over pixels without a depth jump.
/// It is limited to the enlarged box and to the depth of the nearer surface + margin_m.
/// A box without depth gets no mask.
/// Surfaces that touch the object without a jump are included within the box,
/// such as the chair under a person.
/// Cost: linear in the pixels of the boxes, about 1 ms for a box of half the image.
class BoxMasks {
 public:
  /// Throws ConfigError if a parameter is out of range.
  explicit BoxMasks(BoxMaskParams params = BoxMaskParams());

  /// Adds a mask (CV_8UC1, 255 inside) to each selected detection without one.
  /// `depth`: CV_32FC1 or CV_16UC1 in units of `unit_m`, in the pixels of the boxes.
  /// Any other type adds no mask.
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

/// A box detector that also creates masks from the depth image of the frame.
/// It adds instance masks and, if the detector has no label image, one merged from them.
/// Pipelines with `semantic_mask` can therefore use it.
/// Without a depth image it returns the detector's result unchanged.
class BoxMaskProvider final : public SemanticProvider {
 public:
  BoxMaskProvider(std::unique_ptr<SemanticProvider> detector, BoxMaskParams params)
      : detector_(std::move(detector)), masks_(std::move(params)) {}

  std::string name() const override { return detector_->name(); }

  std::optional<SemanticResult> infer(const SemanticImage& image) override;

 private:
  std::unique_ptr<SemanticProvider> detector_;
  BoxMasks masks_;
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/semantic/detail/box_masks-inl.hpp>
#endif
