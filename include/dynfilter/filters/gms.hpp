// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <dynfilter/core/filter.hpp>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/needs.hpp>
#include <dynfilter/config/parameters.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/correspondence/correspondences.hpp>
#include <dynfilter/filters/detail/grid_motion_statistics.hpp>
#include <dynfilter/correspondence/match.hpp>
#include <dynfilter/evidence/evidence.hpp>
#include <opencv2/core/types.hpp>
#include <string>
#include <vector>

namespace dynfilter {

struct GmsFilterParams {
  int grid_cells = 0;
  double matches_per_cell = 2.0;
  double factor = 3.0;
  bool every_pair = true;
  bool rotation = false;
  bool scale = false;
  int min_matches = 50;
  bool keyframe = false;
  int gap_frames = 1;

  /// Parameters of Bian et al. 2017.
  static GmsFilterParams published();

  static const FieldTable<GmsFilterParams>& fields();
  GmsParams statistics() const { return {grid_cells, matches_per_cell, factor, every_pair, rotation, scale}; }
};

/// Rejects features whose match has too little support from the matches around it
/// (Bian et al. 2017; Zhou et al. sec. 3.1).
///
/// Formula:  kept if S >= factor * sqrt(n).
///           S is the number of matches from the surrounding 3 x 3 cells
///           to the 3 x 3 cells around the target.
///           The mean number of matches in these cells is n (filters/detail/grid_motion_statistics.hpp).
/// Needs:    correspondences of any kind.
/// Abstains: without a match, and with fewer than min_matches.
/// Blind to: large movers, whose matches support each other; motion within a cell.
/// State:    none; the pipeline keeps gap_frames frames.
/// Cost:     about 0.05 ms for 1000 matches, 8 times that with rotation, 5 times with scale.
class GmsFilter final : public NamedFilter<GmsFilter> {
 public:
  using Params = GmsFilterParams;
  static constexpr const char* kName = "gms";
  static constexpr const char* kSummary =
      "features whose match has too little support from surrounding matches";

  explicit GmsFilter(Params params = Params());

  Needs needs() const override { return {Input::Correspondence, Input::None, params_.gap_frames}; }

  void apply(const Evidence& evidence, Votes& votes) override;

 private:
  static bool usable(const Evidence& evidence, const Match& match, std::size_t i) {
    return match.found(i) && detail::finite(evidence.pixels()[i]) &&
           detail::finite(match.correspondences.reference_px[i]);
  }

  /// Size of the images: from the image or the camera, else the extent of the points.
  static cv::Size image_size(const FrameView& frame, const std::vector<cv::Point2f>& now,
                             const std::vector<cv::Point2f>& then);

  Params params_;
  GridMotionStatistics statistics_;
  std::vector<std::uint8_t> kept_;
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/filters/detail/gms-inl.hpp>
#endif
