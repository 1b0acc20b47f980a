// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/pipeline/depth_layers.hpp>

#include <algorithm>
#include <dynfilter/core/append_text.hpp>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/inline.hpp>
#include <opencv2/core.hpp>
#include <utility>

namespace dynfilter {

DYNFILTER_INLINE const FieldTable<DepthLayersParams>& DepthLayersParams::fields() {
  using P = DepthLayersParams;
  static const FieldTable<P> table{
      real("max_gap_m", &P::max_gap_m, "m", {0, 10}, "smallest depth gap between two layers"),
      integer("min_points", &P::min_points, "features", {1, 1000},
              "smallest number of dynamic features in a layer that counts as an object"),
      real("min_share", &P::min_share, "", {0, 1},
           "smallest share of the stage's dynamic features in a layer that counts as an object"),
      real("margin_px", &P::margin_px, "px", {0, 1000}, "margin around a layer's features in the image"),
      real("margin_m", &P::margin_m, "m", {0, 10}, "margin before and behind a layer's features in depth"),
  };
  return table;
}

DYNFILTER_INLINE DepthLayersStage::DepthLayersStage(std::string path, Stages children, Params params)
    : Combinator(kName, std::move(path), std::move(children)), params_(params) {
  check_parameters(params_, this->path());
}

DYNFILTER_INLINE Needs DepthLayersStage::needs() const {
  Needs all = Combinator::needs();
  all.optional = all.optional | Input::Depth;
  return all;
}

DYNFILTER_INLINE void DepthLayersStage::decide(FrameEvidence& evidence, StageReports& reports,
                                               std::size_t self, Judgement& out) {
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

inline void DepthLayersStage::Layer::add(const cv::Point2f& px) {
  left = std::min(left, px.x), right = std::max(right, px.x);
  top = std::min(top, px.y), bottom = std::max(bottom, px.y);
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
  const auto px = static_cast<float>(params_.margin_px), m = static_cast<float>(params_.margin_m);
  Layer layer;
  for (std::size_t k = begin; k < end; ++k) layer.add(evidence.pixels()[order_[k]]);
  layer.left -= px, layer.top -= px, layer.right += px, layer.bottom += px;
  layer.nearest_m = evidence.depths_m()[order_[begin]] - m;
  layer.farthest_m = evidence.depths_m()[order_[end - 1]] + m;
  layers_.push_back(layer);
}

}  // namespace dynfilter
