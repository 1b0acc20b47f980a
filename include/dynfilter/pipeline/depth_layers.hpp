// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <dynfilter/core/needs.hpp>
#include <dynfilter/config/parameters.hpp>
#include <dynfilter/core/verdict.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/evidence/frame_evidence.hpp>
#include <dynfilter/pipeline/combinator.hpp>
#include <dynfilter/pipeline/judgement.hpp>
#include <limits>
#include <opencv2/core/types.hpp>
#include <string>
#include <vector>

namespace dynfilter {

struct DepthLayersParams {
  double max_gap_m = 0.2;
  int min_points = 4;
  double min_share = 0.2;
  double margin_px = 10;
  double margin_m = 0.1;

  static const FieldTable<DepthLayersParams>& fields();
};

/// `depth_layers`: splits the stage's dynamic features into layers at gaps in their depths.
/// A layer with enough of them is an object.
/// All features in its image rectangle and depth range become dynamic.
/// Dynamic features of smaller layers become unknown.
/// They are usually background that the stage included at an outline.
/// All other features, and features without depth, keep their vote.
class DepthLayersStage final : public Combinator {
 public:
  using Params = DepthLayersParams;
  static constexpr const char* kName = "depth_layers";
  static constexpr const char* kSummary =
      "splits the stage's dynamic features by depth; large layers are filled, small ones become unknown";
  static constexpr const char* kDynamic = "if it is among the dynamic features of one depth layer";

  DepthLayersStage(std::string path, Stages children, Params params = Params());

  Needs needs() const override;

 protected:
  void decide(FrameEvidence& evidence, StageReports& reports, std::size_t self, Judgement& out) override;

 private:
  struct Layer {
    float left = std::numeric_limits<float>::max(), top = left, right = -left, bottom = -left;
    float nearest_m = 0, farthest_m = 0;

    void add(const cv::Point2f& px);
    bool holds(const cv::Point2f& px, float z_m) const {
      return px.x >= left && px.x <= right && px.y >= top && px.y <= bottom && z_m >= nearest_m &&
             z_m <= farthest_m;
    }
  };

  void find_layers(FrameEvidence& evidence, const Votes& votes);
  void add_layer(FrameEvidence& evidence, std::size_t begin, std::size_t end);

  Params params_;
  std::vector<std::size_t> order_;
  std::vector<Layer> layers_;
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/pipeline/detail/depth_layers-inl.hpp>
#endif
