// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <dynfilter/core/printable_text.hpp>
#include <dynfilter/evidence/frame_evidence.hpp>
#include <dynfilter/pipeline/combinator.hpp>
#include <limits>
#include <opencv2/core.hpp>
#include <vector>

namespace dynfilter {

struct DepthLayersParams {
  double max_gap_m = 0.2;
  int min_points = 4;
  /// Smallest share of the stage's dynamic features in a layer that is an object. Not a key: code sets it.
  double min_share = 0.2;
  /// Margin around a layer's features in the image. Not a key: code sets it.
  double margin_px = 10;
  /// Margin before and behind a layer's features in depth.
  static constexpr double kMargin_m = 0.1;

  static const FieldTable<DepthLayersParams>& fields() {
    using P = DepthLayersParams;
    static const FieldTable<P> table{
        real("max_gap_m", &P::max_gap_m, "m", {0, 10}, "smallest depth gap between two layers"),
        integer("min_points", &P::min_points, "features", {1, 1000},
                "smallest number of dynamic features in a layer that counts as an object"),
    };
    return table;
  }
};

/// `depth_layers`: splits the stage's dynamic features into layers at gaps in their depths. A layer with
/// enough of them is an object. All features in its image rectangle and depth range become dynamic. Dynamic
/// features of smaller layers become unknown. They are usually background that the stage included at an
/// outline. All other features, and features without depth, keep their vote.
class DepthLayersStage final : public ParametricCombinator<DepthLayersStage, DepthLayersParams> {
 public:
  using ParametricCombinator::ParametricCombinator;
  static constexpr const char* kName = "depth_layers";
  static constexpr const char* kSummary =
      "splits the stage's dynamic features by depth; large layers are filled, small ones become unknown";
  static constexpr const char* kDynamic = "if it is among the dynamic features of one depth layer";

  Needs needs() const override {
    Needs all = Combinator::needs();
    all.optional = all.optional | Input::Depth;
    return all;
  }

 protected:
  void decide(FrameEvidence& evidence, StageReports& reports, std::size_t self, Judgement& out) override;

 private:
  struct Layer {
    float left = std::numeric_limits<float>::max(), top = left, right = -left, bottom = -left;
    float nearest_m = 0, farthest_m = 0;

    /// A feature at `px`.
    void add(const cv::Point2f& px) {
      left = std::min(left, px.x), right = std::max(right, px.x);
      top = std::min(top, px.y), bottom = std::max(bottom, px.y);
    }
    bool holds(const cv::Point2f& px, float z_m) const {
      return px.x >= left && px.x <= right && px.y >= top && px.y <= bottom && z_m >= nearest_m &&
             z_m <= farthest_m;
    }
  };

  void find_layers(FrameEvidence& evidence, const Votes& votes);
  void add_layer(FrameEvidence& evidence, std::size_t begin, std::size_t end);

  std::vector<std::size_t> order_;
  std::vector<Layer> layers_;
};

inline void DepthLayersStage::decide(FrameEvidence& evidence, StageReports& reports, std::size_t self,
                                     Judgement& out) {
  children_[0]->judge(evidence, reports, out);
  if ((evidence.inputs() & Input::Depth) == Input::None) {
    reports[self].note = "no depth: the stage's votes are kept";
    return;
  }
  find_layers(evidence, out.votes);
  append_text(reports[self].note, layers_.size(), " layers");
  for (std::size_t i = 0; i < evidence.size(); ++i) {
    const float z = evidence.depths_m()[i];
    if (!evidence.judged(i) || !valid_depth(z)) continue;
    const bool inside = std::any_of(layers_.begin(), layers_.end(),
                                    [&](const Layer& l) { return l.holds(evidence.pixels()[i], z); });
    if (inside && out.votes[i] != Vote::Dynamic)
      set(out, i, Vote::Dynamic, std::max(out.votes.suspicion(i), 0.75F), own_reason(self));
    if (!inside && out.votes[i] == Vote::Dynamic) set(out, i, Vote::Unknown, Votes::kNoIdea, 0);
  }
}

inline void DepthLayersStage::find_layers(FrameEvidence& evidence, const Votes& votes) {
  layers_.clear();
  order_.clear();
  for (std::size_t i = 0; i < evidence.size(); ++i)
    if (votes[i] == Vote::Dynamic && valid_depth(evidence.depths_m()[i])) order_.push_back(i);
  const std::vector<float>& z = evidence.depths_m();
  std::sort(order_.begin(), order_.end(),
            [&](std::size_t a, std::size_t b) { return z[a] < z[b] || (z[a] == z[b] && a < b); });
  for (std::size_t begin = 0, end = 0; begin < order_.size(); begin = end) {
    end = begin + 1;
    while (end < order_.size() &&
           static_cast<double>(z[order_[end]] - z[order_[end - 1]]) <= params_.max_gap_m)
      ++end;
    const auto points = static_cast<double>(end - begin);
    if (points < params_.min_points || points < params_.min_share * static_cast<double>(order_.size()))
      continue;
    add_layer(evidence, begin, end);
  }
}

inline void DepthLayersStage::add_layer(FrameEvidence& evidence, std::size_t begin, std::size_t end) {
  const auto px = static_cast<float>(params_.margin_px), m = static_cast<float>(Params::kMargin_m);
  Layer layer;
  for (std::size_t k = begin; k < end; ++k) layer.add(evidence.pixels()[order_[k]]);
  layer.left -= px, layer.top -= px, layer.right += px, layer.bottom += px;
  layer.nearest_m = evidence.depths_m()[order_[begin]] - m;
  layer.farthest_m = evidence.depths_m()[order_[end - 1]] + m;
  layers_.push_back(layer);
}

}  // namespace dynfilter
