// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <dynfilter/config/registry.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/correspondence/correspondences.hpp>
#include <dynfilter/evidence/evidence.hpp>
#include <dynfilter/filters/detail/grid_motion_statistics.hpp>
#include <opencv2/core.hpp>
#include <vector>

namespace dynfilter {

struct GmsFilterParams {
  int grid_cells = 0;
  /// Mean matches per cell if grid_cells is 0, within 4 to 20 cells per side.
  static constexpr double kMatchesPerCell = 2.0;
  double factor = 3.0;
  bool every_pair = true;
  /// Smallest number of matches; with fewer, the filter abstains.
  static constexpr int kMinMatches = 50;

  /// Parameters of Bian et al. 2017.
  static GmsFilterParams published();

  static const FieldTable<GmsFilterParams>& fields() {
    using P = GmsFilterParams;
    static const FieldTable<P> table{
        integer("grid_cells", &P::grid_cells, "cells", {0, 40},
                "grid cells per side (published 20); 0: chosen from the number of matches"),
        real("factor", &P::factor, "", {0, 100},
             "a match needs this times sqrt(n) supporters, n being the mean number of matches in a cell "
             "(published 6)"),
        flag("every_pair", &P::every_pair,
             "judge every match; false, as published: only matches to the most frequent partner of a cell"),
    };
    return table;
  }
  /// What GridMotionStatistics works with.
  GmsParams statistics() const { return {grid_cells, kMatchesPerCell, factor, every_pair}; }
};

/// Rejects features whose match has too little support from the matches around it (Bian et al. 2017; Zhou et
/// al. sec. 3.1).
///
/// Formula:  kept if S >= factor * sqrt(n). S is the number of matches from the surrounding 3 x 3 cells to
///           the 3 x 3 cells around the target. The mean number of matches in these cells is n
///           (filters/detail/grid_motion_statistics.hpp).
/// Needs:    correspondences of any kind.
/// Abstains: without a match, and with fewer than 50.
/// Blind to: large movers, whose matches support each other; motion within a cell.
/// State:    none; the pipeline keeps the last frame.
/// Cost:     about 0.05 ms for 1000 matches.
class GmsFilter final : public ParametricFilter<GmsFilter, GmsFilterParams> {
 public:
  using ParametricFilter::ParametricFilter;
  static constexpr const char* kName = "gms";
  static constexpr const char* kSummary =
      "features whose match has too little support from surrounding matches";

  Needs needs() const override { return {Input::Correspondence, Input::None, 1}; }

  void apply(const Evidence& evidence, Votes& votes) override;

 private:
  static bool usable(const Evidence& evidence, const Match& match, std::size_t i) {
    return match.found(i) && detail::finite(evidence.pixels()[i]) &&
           detail::finite(match.correspondences.reference_px[i]);
  }

  /// Size of the images: from the image or the camera, else the extent of the points.
  static cv::Size image_size(const FrameView& frame, const std::vector<cv::Point2f>& now,
                             const std::vector<cv::Point2f>& then);

  GridMotionStatistics statistics_{params_.statistics()};
  std::vector<std::uint8_t> kept_;
};

inline GmsFilterParams GmsFilterParams::published() {
  GmsFilterParams params;
  params.grid_cells = 20;
  params.factor = 6.0;
  params.every_pair = false;
  return params;
}

inline void GmsFilter::apply(const Evidence& evidence, Votes& votes) {
  const Match& match = evidence.match({});
  if (match.reference == nullptr) return votes.note("no earlier frame");
  const std::size_t matches = match.correspondences.count();
  if (matches < static_cast<std::size_t>(Params::kMinMatches))
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
