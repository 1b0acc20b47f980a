// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <dynfilter/cluster/depth_growth.hpp>
#include <dynfilter/core/printable_text.hpp>
#include <dynfilter/evidence/frame_evidence.hpp>
#include <dynfilter/pipeline/combinator.hpp>
#include <dynfilter/pipeline/detail/neighbour_counts.hpp>
#include <opencv2/core.hpp>
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
  /// Smallest number of dynamic neighbours, for points and image. Not a key: code sets it.
  int min_neighbours = 2;
  /// Smallest share of dynamic neighbours among those that are not unknown, for points and image. Not a key:
  /// code sets it.
  double min_share = 0.5;
  /// How often newly added features are grown again, for points and image. Not a key: code sets it.
  int rounds = 3;
  /// Relative depth step between neighbouring pixels that counts as an edge, for depth.
  static constexpr double kMaxStepShare = 0.015;
  double max_reach_m = 0.5;

  static const FieldTable<ClusterExpandParams>& fields() {
    using P = ClusterExpandParams;
    static const FieldTable<P> table{
        choice(
            "space", &P::space,
            {{"points", ExpandSpace::Points}, {"image", ExpandSpace::Image}, {"depth", ExpandSpace::Depth}},
            "points uses neighbours in 3-D, image neighbours in pixels, depth grows over the depth image"),
        real("radius_m", &P::radius_m, "m", {1e-3, 10}, "radius of the neighbourhood, for space points"),
        real("radius_px", &P::radius_px, "px", {1, 1000}, "radius of the neighbourhood, for space image"),
        real("max_reach_m", &P::max_reach_m, "m", {0, 100},
             "largest 3-D distance from a dynamic feature, for depth; 0: no limit"),
    };
    return table;
  }
};

/// `cluster_expand`: grows the stage's dynamic features to their neighbours.
/// Neighbours are in 3-D, in the image, or connected in the depth image without a jump (DynaSLAM's region
/// growing). Added features become dynamic regardless of the stage's vote. All others keep it.
/// Without the data for the space, such as depth, nothing is grown.
class ClusterExpandStage final : public ParametricCombinator<ClusterExpandStage, ClusterExpandParams> {
 public:
  using ParametricCombinator::ParametricCombinator;
  static constexpr const char* kName = "cluster_expand";
  static constexpr const char* kSummary = "grows the stage's dynamic features to their neighbours";
  static constexpr const char* kDynamic =
      "if the stage votes dynamic, or enough of its neighbours are dynamic";

  Needs needs() const override {
    Needs all = Combinator::needs();
    if (params_.space != ExpandSpace::Image) all.optional = all.optional | Input::Depth | Input::Camera;
    return all;
  }

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

  DepthGrowth growth_{{Params::kMaxStepShare, params_.max_reach_m}};
  NeighbourCounts neighbours_;
  cv::Mat grown_;
  std::vector<cv::Point2f> seeds_px_;
  std::vector<cv::Point3f> flat_;
};

inline void ClusterExpandStage::decide(FrameEvidence& evidence, StageReports& reports, std::size_t self,
                                       Judgement& out) {
  children_[0]->judge(evidence, reports, out);
  const std::size_t before = out.votes.count(Vote::Dynamic);
  if (before == 0) return;
  if (params_.space == ExpandSpace::Depth)
    grow_over_depth(evidence, own_reason(self), out);
  else
    grow_by_neighbours(evidence, own_reason(self), out);
  append_text(reports[self].note, out.votes.count(Vote::Dynamic) - before, " features added");
}

inline void ClusterExpandStage::grow_over_depth(const FrameEvidence& evidence, std::uint64_t reason,
                                                Judgement& out) {
  const FrameView& frame = evidence.frame();
  seeds_px_.clear();
  for (std::size_t i = 0; i < evidence.size(); ++i)
    if (out.votes[i] == Vote::Dynamic) seeds_px_.push_back(evidence.pixels()[i]);
  growth_.grow(frame.depth, frame.depth_unit_m, frame.camera.value_or(Camera()), seeds_px_, grown_);
  for (std::size_t i = 0; i < evidence.size(); ++i)
    if (out.votes[i] != Vote::Dynamic && evidence.judged(i) && is_grown(evidence.pixels()[i]))
      add(i, reason, out);
}

inline bool ClusterExpandStage::is_grown(const cv::Point2f& px) const {
  if (!(px.x >= -0.5F && px.y >= -0.5F && px.x < static_cast<float>(grown_.cols) &&
        px.y < static_cast<float>(grown_.rows)))
    return false;
  const int x = std::min(cvRound(px.x), grown_.cols - 1), y = std::min(cvRound(px.y), grown_.rows - 1);
  return grown_.at<std::uint8_t>(y, x) != 0;
}

inline void ClusterExpandStage::grow_by_neighbours(FrameEvidence& evidence, std::uint64_t reason,
                                                   Judgement& out) {
  const Span<const cv::Point3f> places = this->places(evidence);
  neighbours_.build(places);
  for (int round = 0; round < params_.rounds; ++round) {
    neighbours_.mark([&](std::uint32_t i) { return marks(out.votes[i]); });
    bool grew = false;
    for (std::size_t i = 0; i < evidence.size(); ++i) {
      if (out.votes[i] == Vote::Dynamic || !evidence.judged(i)) continue;
      const NeighbourCounts::Counts around = neighbours_.around(places[i], radius());
      const int dynamic = around.first, known = around.second - marks(out.votes[i]).second;  // not itself
      if (dynamic < params_.min_neighbours || dynamic < params_.min_share * known) continue;
      add(i, reason, out);
      grew = true;
    }
    if (!grew) return;
  }
}

inline Span<const cv::Point3f> ClusterExpandStage::places(const FrameEvidence& evidence) {
  if (params_.space == ExpandSpace::Points) return evidence.points_m();
  flat_.clear();
  for (const cv::Point2f& px : evidence.pixels()) flat_.emplace_back(px.x, px.y, 0.0F);
  return flat_;
}

}  // namespace dynfilter
