// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <dynfilter/core/detection.hpp>
#include <dynfilter/core/filter.hpp>
#include <dynfilter/core/needs.hpp>
#include <dynfilter/config/parameters.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/evidence/box_foreground.hpp>
#include <dynfilter/evidence/evidence.hpp>
#include <dynfilter/evidence/semantic_input.hpp>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <string>
#include <vector>

namespace dynfilter {

struct BoxBlurParams {
  std::vector<std::string> classes = moving_classes();
  double min_score = 0.4;
  double min_sharpness = 0.5;
  int max_age_frames = 0;

  static const FieldTable<BoxBlurParams>& fields();
};

/// Rejects features in boxes that are blurred while the rest of the image is sharp.
/// The blur shows that the object moves. This is the blur filter of COEB-SLAM.
///
/// Formula:  E / E_rest < min_sharpness for the second differences along x or along y.
///           E is their variance over the variance of the grey values, inside the box.
///           E_rest is the same outside all such boxes.
///           Motion blur has a direction, so the smaller of the two ratios decides.
///           A smooth surface has little of both variances.
/// Needs:    boxes, grey image.
/// Votes:    Dynamic in a blurred box, Static in a sharp one, Unknown outside.
/// Abstains: without boxes, in boxes without texture, and if the image outside them has no texture.
/// Blind to: motion that is slow relative to the exposure time.
///           Objects out of focus and stripes along x or y are mistaken for motion.
/// State:    none.
/// Cost:     about 0.3 ms for 640 x 480. Reads every second pixel of every second row once.
class BoxBlurFilter final : public NamedFilter<BoxBlurFilter> {
 public:
  using Params = BoxBlurParams;
  static constexpr const char* kName = "box_blur";
  static constexpr const char* kSummary =
      "features in boxes that are blurred while the rest of the image is sharp";

  explicit BoxBlurFilter(Params params = Params());

  Needs needs() const override {
    return {Input::Detections | Input::GreyImage, Input::Correspondence,
            LateResult::history_frames(params_.max_age_frames)};
  }

  void apply(const Evidence& evidence, Votes& votes) override;

 private:
  static constexpr double kMinVariance = 25;  // of grey values: 5 grey levels of texture
  static constexpr double kMinSamples = 200;
  struct Box {
    cv::Rect place;
    std::size_t begin = 0, end = 0;  ///< in inside_
  };
  struct Sharpness {
    bool known = false;
    double along_x = 0, along_y = 0;
  };
  struct Moments {
    double n = 0, sum = 0, squares = 0;
    void add(double value) { n += 1, sum += value, squares += value * value; }
    double variance() const { return n > 0 ? std::max(0.0, squares / n - sum / n * (sum / n)) : 0; }
  };

  void collect(const Evidence& evidence, const LateResult& late);

  void judge(const cv::Mat& grey, const Box& box, const Sharpness& rest, Votes& votes);

  Sharpness sharpness(const cv::Mat& grey, const cv::Rect& area, bool outside_boxes);
  /// Counts for each pixel of row y how many boxes cover it.
  void cover_row(int y, int columns);

  Params params_;
  DetectionFilter wanted_;
  std::vector<Box> boxes_;
  std::vector<std::uint32_t> inside_;    ///< features in all boxes, one box after the other
  std::vector<std::size_t> inside_box_;  ///< features in one
  std::vector<int> in_boxes_;            ///< per column of a row: how many boxes cover it
  BoxScratch scratch_;
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/filters/detail/box_blur-inl.hpp>
#endif
