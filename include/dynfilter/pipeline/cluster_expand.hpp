// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <dynfilter/cluster/depth_growth.hpp>
#include <dynfilter/pipeline/detail/neighbour_counts.hpp>
#include <dynfilter/core/needs.hpp>
#include <dynfilter/config/parameters.hpp>
#include <dynfilter/core/verdict.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/evidence/frame_evidence.hpp>
#include <dynfilter/pipeline/combinator.hpp>
#include <dynfilter/pipeline/judgement.hpp>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <string>
#include <utility>
#include <vector>

namespace dynfilter {

/// Space in which neighbours are defined.
enum class ExpandSpace {
  Points,  ///< distance in 3-D
  Image,   ///< distance in pixels
  Depth    ///< growth over the depth image, from pixel to pixel
};

struct ClusterExpandParams {
  ExpandSpace space = ExpandSpace::Points;
  double radius_m = 0.1;
  double radius_px = 20;
  int min_neighbours = 2;
  double min_share = 0.5;
  int rounds = 3;
  double max_step_share = 0.015;
  double max_reach_m = 0.5;

  static const FieldTable<ClusterExpandParams>& fields();
};

/// `cluster_expand`: grows the stage's dynamic features to their neighbours.
/// Neighbours are in 3-D, in the image, or connected in the depth image without a jump
/// (DynaSLAM's region growing).
/// Added features become dynamic regardless of the stage's vote. All others keep it.
/// Without the data for the space, such as depth, nothing is grown.
class ClusterExpandStage final : public Combinator {
 public:
  using Params = ClusterExpandParams;
  static constexpr const char* kName = "cluster_expand";
  static constexpr const char* kSummary = "grows the stage's dynamic features to their neighbours";
  static constexpr const char* kDynamic =
      "if the stage votes dynamic, or enough of its neighbours are dynamic";

  ClusterExpandStage(std::string path, Stages children, Params params = Params());

  Needs needs() const override;

 protected:
  void decide(FrameEvidence& evidence, StageReports& reports, std::size_t self, Judgement& out) override;

 private:
  void add(std::size_t i, std::uint64_t reason, Judgement& out) const {
    set(out, i, Vote::Dynamic, std::max(out.votes.suspicion(i), 0.75F), out.reasons[i] | reason);
  }

  void grow_over_depth(const FrameEvidence& evidence, std::uint64_t reason, Judgement& out);
  bool is_grown(const cv::Point2f& px) const;

  void grow_by_neighbours(FrameEvidence& evidence, std::uint64_t reason, Judgement& out);
  /// Positions of the features in the space of the parameters, and the radius in its unit.
  Span<const cv::Point3f> places(const FrameEvidence& evidence);
  double radius() const { return params_.space == ExpandSpace::Image ? params_.radius_px : params_.radius_m; }
  /// 1 or 0 each: dynamic, known.
  static NeighbourCounts::Counts marks(Vote vote) {
    return {vote == Vote::Dynamic ? 1 : 0, vote != Vote::Unknown ? 1 : 0};
  }

  Params params_;
  DepthGrowth growth_;
  NeighbourCounts neighbours_;
  cv::Mat grown_;
  std::vector<cv::Point2f> seeds_px_;
  std::vector<cv::Point3f> flat_;
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/pipeline/detail/cluster_expand-inl.hpp>
#endif
