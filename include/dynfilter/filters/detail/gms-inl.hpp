// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/filters/gms.hpp>

#include <algorithm>
#include <dynfilter/core/inline.hpp>
#include <opencv2/core.hpp>

namespace dynfilter {

DYNFILTER_INLINE GmsFilterParams GmsFilterParams::published() {
  GmsFilterParams params;
  params.grid_cells = 20;
  params.factor = 6.0;
  params.every_pair = false;
  return params;
}

DYNFILTER_INLINE const FieldTable<GmsFilterParams>& GmsFilterParams::fields() {
  using P = GmsFilterParams;
  static const FieldTable<P> table{
      integer("grid_cells", &P::grid_cells, "cells", {0, 40},
              "grid cells per side (published 20); 0: chosen from the number of matches"),
      real("matches_per_cell", &P::matches_per_cell, "matches", {0.1, 1000},
           "mean matches per cell if grid_cells is 0, within 4 to 20 cells per side"),
      real("factor", &P::factor, "", {0, 100},
           "a match needs this times sqrt(n) supporters, n being the mean number of matches in a cell "
           "(published 6)"),
      flag("every_pair", &P::every_pair,
           "judge every match; false, as published: only matches to the most frequent partner of a cell"),
      flag("rotation", &P::rotation, "test eight rotations between the images and keep the best"),
      flag("scale", &P::scale, "test five scale ratios between the images, 1/2 to 2, and keep the best"),
      integer("min_matches", &P::min_matches, "matches", {1, 100000},
              "smallest number of matches; with fewer, the filter abstains"),
      flag("keyframe", &P::keyframe, "compare with the last keyframe instead of gap_frames back"),
      integer("gap_frames", &P::gap_frames, "frames", {1, 30}, "number of frames back"),
  };
  return table;
}

DYNFILTER_INLINE GmsFilter::GmsFilter(Params params) : params_(params), statistics_(params.statistics()) {
  check_parameters(params_, kName);
}

DYNFILTER_INLINE void GmsFilter::apply(const Evidence& evidence, Votes& votes) {
  const Match& match = evidence.match({params_.keyframe, params_.gap_frames});
  if (match.reference == nullptr) return votes.note("no earlier frame");
  const std::size_t matches = match.correspondences.count();
  if (matches < static_cast<std::size_t>(params_.min_matches))
    return votes.note("too few matches: ", matches);
  const std::vector<cv::Point2f>& then = match.correspondences.reference_px;
  const cv::Size size = image_size(evidence.frame(), evidence.pixels(), then);
  const std::size_t kept =
      statistics_.run(evidence.pixels(), size, then, size, match.correspondences.found, kept_);
  const auto cells = statistics_.cells_for(matches);
  votes.note("kept ", kept, " of ", matches, " matches, ", cells, " x ", cells, " cells");
  for (std::size_t i = 0; i < evidence.size(); ++i)
    if (evidence.judged(i) && usable(evidence, match, i))
      votes.cast(i, kept_[i] != 0 ? Vote::Static : Vote::Dynamic);
}

inline cv::Size GmsFilter::image_size(const FrameView& frame, const std::vector<cv::Point2f>& now,
                                      const std::vector<cv::Point2f>& then) {
  if (!frame.grey.empty()) return frame.grey.size();
  if (!frame.depth.empty()) return frame.depth.size();
  if (frame.camera && frame.camera->width_px > 0 && frame.camera->height_px > 0)
    return {frame.camera->width_px, frame.camera->height_px};
  cv::Point2f most(1, 1);
  for (const auto* points : {&now, &then})
    for (const cv::Point2f& p : *points)
      if (p.x < 1e6F && p.y < 1e6F) most = {std::max(most.x, p.x), std::max(most.y, p.y)};
  return {static_cast<int>(most.x) + 1, static_cast<int>(most.y) + 1};
}

}  // namespace dynfilter
