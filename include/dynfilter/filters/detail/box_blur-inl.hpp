// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/filters/box_blur.hpp>

#include <cstdint>
#include <dynfilter/core/inline.hpp>
#include <numeric>
#include <opencv2/core.hpp>
#include <utility>

namespace dynfilter {

DYNFILTER_INLINE const FieldTable<BoxBlurParams>& BoxBlurParams::fields() {
  using P = BoxBlurParams;
  static const FieldTable<P> table{
      words("classes", &P::classes, "names of the classes that may move; empty: all classes"),
      real("min_score", &P::min_score, "", {0, 1}, "smallest score of a box that is used"),
      real("min_sharpness", &P::min_sharpness, "", {0, 100},
           "sharpness of a box relative to the rest of the image below which it counts as motion-blurred"),
      integer("max_age_frames", &P::max_age_frames, "frames", {0, 100},
              "largest age of boxes; boxes of an older frame are carried to this one up to this age"),
  };
  return table;
}

DYNFILTER_INLINE BoxBlurFilter::BoxBlurFilter(Params params)
    : params_(std::move(params)), wanted_{params_.classes, {}, params_.min_score} {
  check_parameters(params_, kName);
}

DYNFILTER_INLINE void BoxBlurFilter::apply(const Evidence& evidence, Votes& votes) {
  const LateResult late = LateResult::boxes(evidence, params_.max_age_frames, votes);
  if (!late.usable()) return;
  collect(evidence, late);
  if (boxes_.empty()) return;
  const cv::Mat& grey = evidence.frame().grey;
  const Sharpness rest = sharpness(grey, cv::Rect(0, 0, grey.cols, grey.rows), true);
  if (!(rest.along_x > 0 && rest.along_y > 0)) return votes.note("no textured image outside the boxes");
  for (const Box& box : boxes_) judge(grey, box, rest, votes);
}

inline void BoxBlurFilter::collect(const Evidence& evidence, const LateResult& late) {
  boxes_.clear();
  inside_.clear();
  const cv::Rect2d image(0, 0, evidence.frame().grey.cols, evidence.frame().grey.rows);
  for (const Detection& detection : late.detections()) {
    if (!wanted_.wants(detection)) continue;
    Box box;
    const cv::Rect2f now = features_in_box(evidence, detection.box, 0, late, scratch_, inside_box_);
    box.place = cv::Rect(cv::Rect2d(now) & image);
    if (box.place.empty()) continue;
    box.begin = inside_.size();
    for (const std::size_t i : inside_box_) inside_.push_back(static_cast<std::uint32_t>(i));
    box.end = inside_.size();
    boxes_.push_back(box);
  }
}

inline void BoxBlurFilter::judge(const cv::Mat& grey, const Box& box, const Sharpness& rest, Votes& votes) {
  const Sharpness own = sharpness(grey, box.place, false);
  if (!own.known) return;
  const double share = std::min(own.along_x / rest.along_x, own.along_y / rest.along_y);
  for (std::size_t k = box.begin; k < box.end; ++k) {
    const std::size_t i = inside_[k];
    if (votes[i] == Vote::Dynamic) continue;
    votes.cast(i, share < params_.min_sharpness ? Vote::Dynamic : Vote::Static,
               1.0F - suspicion(share, params_.min_sharpness));
  }
}

inline BoxBlurFilter::Sharpness BoxBlurFilter::sharpness(const cv::Mat& grey, const cv::Rect& area,
                                                         bool outside_boxes) {
  Moments value, x2, y2;
  for (int y = std::max(area.y, 1); y < std::min(area.br().y, grey.rows - 1); y += 2) {
    const std::uint8_t *above = grey.ptr<std::uint8_t>(y - 1), *row = grey.ptr<std::uint8_t>(y),
                       *below = grey.ptr<std::uint8_t>(y + 1);
    if (outside_boxes) cover_row(y, grey.cols);
    for (int x = std::max(area.x, 1); x < std::min(area.br().x, grey.cols - 1); x += 2) {
      if (outside_boxes && in_boxes_[static_cast<std::size_t>(x)] > 0) continue;
      value.add(row[x]);
      x2.add(row[x - 1] + row[x + 1] - 2 * row[x]);
      y2.add(above[x] + below[x] - 2 * row[x]);
    }
  }
  if (value.n < kMinSamples || value.variance() < kMinVariance) return {};
  return {true, x2.variance() / value.variance(), y2.variance() / value.variance()};
}

inline void BoxBlurFilter::cover_row(int y, int columns) {
  in_boxes_.assign(static_cast<std::size_t>(columns) + 1, 0);
  for (const Box& box : boxes_) {
    if (y < box.place.y || y >= box.place.br().y) continue;
    ++in_boxes_[static_cast<std::size_t>(box.place.x)];
    --in_boxes_[static_cast<std::size_t>(box.place.br().x)];
  }
  std::partial_sum(in_boxes_.begin(), in_boxes_.end(), in_boxes_.begin());
}

}  // namespace dynfilter
