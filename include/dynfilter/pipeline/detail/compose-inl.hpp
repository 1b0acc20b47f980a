// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/pipeline/compose.hpp>

#include <dynfilter/core/inline.hpp>
#include <dynfilter/pipeline/cluster_expand.hpp>
#include <dynfilter/pipeline/depth_layers.hpp>
#include <dynfilter/pipeline/logic_stages.hpp>
#include <dynfilter/pipeline/object_vote.hpp>
#include <dynfilter/pipeline/routing_stages.hpp>
#include <dynfilter/pipeline/stage.hpp>
#include <dynfilter/pipeline/temporal_stage.hpp>
#include <dynfilter/pipeline/vote_stage.hpp>

namespace dynfilter {

DYNFILTER_INLINE StagePtr stage(std::unique_ptr<Filter> filter, std::string path) {
  if (path.empty()) path = filter->name();
  return std::make_unique<FilterStage>(std::move(filter), std::move(path));
}

namespace detail {

DYNFILTER_INLINE StagePtr sequence_of(std::vector<StagePtr> members) {
  return std::make_unique<SequenceStage>(SequenceStage::kName, std::move(members));
}
DYNFILTER_INLINE StagePtr first_available_of(std::vector<StagePtr> members) {
  return std::make_unique<FirstAvailableStage>(FirstAvailableStage::kName, std::move(members));
}
DYNFILTER_INLINE StagePtr any_of(std::vector<StagePtr> members) {
  return std::make_unique<AnyStage>(AnyStage::kName, std::move(members));
}
DYNFILTER_INLINE StagePtr all_of(std::vector<StagePtr> members) {
  return std::make_unique<AllStage>(AllStage::kName, std::move(members));
}
DYNFILTER_INLINE StagePtr vote_of(const VoteParams& params, std::vector<StagePtr> members) {
  return std::make_unique<VoteStage>(VoteStage::kName, std::move(members), params);
}

}  // namespace detail

DYNFILTER_INLINE StagePtr negate(StagePtr member) {
  return std::make_unique<NotStage>(NotStage::kName, detail::stages(std::move(member)));
}
DYNFILTER_INLINE StagePtr strict(StagePtr member) {
  return std::make_unique<StrictStage>(StrictStage::kName, detail::stages(std::move(member)));
}
DYNFILTER_INLINE StagePtr gate(StagePtr condition, StagePtr then, StagePtr otherwise) {
  Stages children = detail::stages(std::move(condition), std::move(then));
  if (otherwise) children.push_back(std::move(otherwise));
  return std::make_unique<GateStage>(GateStage::kName, std::move(children));
}
DYNFILTER_INLINE StagePtr by_region(StagePtr inside, StagePtr outside) {
  return std::make_unique<ByRegionStage>(ByRegionStage::kName,
                                         detail::stages(std::move(inside), std::move(outside)));
}
DYNFILTER_INLINE StagePtr object_vote(const ObjectVoteParams& params, StagePtr of) {
  return std::make_unique<ObjectVoteStage>(ObjectVoteStage::kName, detail::stages(std::move(of)), params);
}
DYNFILTER_INLINE StagePtr cluster_expand(const ClusterExpandParams& params, StagePtr of) {
  return std::make_unique<ClusterExpandStage>(ClusterExpandStage::kName, detail::stages(std::move(of)),
                                              params);
}
DYNFILTER_INLINE StagePtr depth_layers(const DepthLayersParams& params, StagePtr of) {
  return std::make_unique<DepthLayersStage>(DepthLayersStage::kName, detail::stages(std::move(of)), params);
}
DYNFILTER_INLINE StagePtr temporal(const TemporalParams& params, StagePtr of) {
  return std::make_unique<TemporalStage>(TemporalStage::kName, detail::stages(std::move(of)), params);
}

}  // namespace dynfilter
