// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/pipeline/pipeline.hpp>
#include <memory>
#include <utility>

/// Pipelines in C++:
///
///     PipelineConfig config;
///     config.before_pose = sequence(stage<SemanticBoxFilter>(),
///                                   any(stage<EpipolarFilter>(), stage<Mine>(params)));
///     Pipeline pipeline(std::move(config));
namespace dynfilter {

using StagePtr = std::unique_ptr<Stage>;

/// A stage with a new filter of type F. Throws ConfigError for invalid parameters.
template <class F>
StagePtr stage(typename F::Params params = typename F::Params()) {
  return std::make_unique<FilterStage>(std::make_unique<F>(std::move(params)), F::kName);
}
/// Wraps an existing filter.
inline StagePtr stage(std::unique_ptr<Filter> filter) {
  std::string path = filter->name();
  return std::make_unique<FilterStage>(std::move(filter), std::move(path));
}

namespace detail {

template <class... S>
Stages stages(S&&... members) {
  Stages result;
  (result.push_back(std::forward<S>(members)), ...);
  return result;
}

}  // namespace detail

/// The combinators of pipeline/combinators.hpp with these stages as children.
/// `negate` is `not` in YAML; `condition` and `otherwise` are `if` and `else`.
template <class... S>
StagePtr sequence(S&&... members) {
  return std::make_unique<SequenceStage>(SequenceStage::kName, detail::stages(std::forward<S>(members)...));
}
template <class... S>
StagePtr any(S&&... members) {
  return std::make_unique<AnyStage>(AnyStage::kName, detail::stages(std::forward<S>(members)...));
}
template <class... S>
StagePtr all(S&&... members) {
  return std::make_unique<AllStage>(AllStage::kName, detail::stages(std::forward<S>(members)...));
}
inline StagePtr negate(StagePtr member) {
  return std::make_unique<NotStage>(NotStage::kName, detail::stages(std::move(member)));
}
inline StagePtr strict(StagePtr member) {
  return std::make_unique<StrictStage>(StrictStage::kName, detail::stages(std::move(member)));
}
inline StagePtr gate(StagePtr condition, StagePtr then) {
  return std::make_unique<GateStage>(GateStage::kName, detail::stages(std::move(condition), std::move(then)));
}
inline StagePtr gate(StagePtr condition, StagePtr then, StagePtr otherwise) {
  return std::make_unique<GateStage>(
      GateStage::kName, detail::stages(std::move(condition), std::move(then), std::move(otherwise)));
}
inline StagePtr by_region(StagePtr inside, StagePtr outside) {
  return std::make_unique<ByRegionStage>(ByRegionStage::kName,
                                         detail::stages(std::move(inside), std::move(outside)));
}
template <class... S>
StagePtr vote(VoteParams params, S&&... members) {
  return std::make_unique<VoteStage>(VoteStage::kName, detail::stages(std::forward<S>(members)...),
                                     std::move(params));
}
inline StagePtr object_vote(ObjectVoteParams params, StagePtr of) {
  return std::make_unique<ObjectVoteStage>(ObjectVoteStage::kName, detail::stages(std::move(of)),
                                           std::move(params));
}
inline StagePtr cluster_expand(ClusterExpandParams params, StagePtr of) {
  return std::make_unique<ClusterExpandStage>(ClusterExpandStage::kName, detail::stages(std::move(of)),
                                              params);
}
inline StagePtr depth_layers(DepthLayersParams params, StagePtr of) {
  return std::make_unique<DepthLayersStage>(DepthLayersStage::kName, detail::stages(std::move(of)), params);
}
inline StagePtr temporal(TemporalParams params, StagePtr of) {
  return std::make_unique<TemporalStage>(TemporalStage::kName, detail::stages(std::move(of)), params);
}

}  // namespace dynfilter
