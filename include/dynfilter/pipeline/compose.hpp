// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/filter.hpp>
#include <dynfilter/pipeline/pipeline.hpp>
#include <memory>
#include <string>
#include <utility>
#include <vector>

/// Pipelines in C++:
///
///     PipelineConfig config;
///     config.before_pose = sequence(stage<SemanticBoxFilter>(),
///                                   any(stage<EpipolarFilter>(), stage<Mine>(params)));
///     Pipeline pipeline(std::move(config));
namespace dynfilter {

// Each is defined beside its stage: pipeline/vote_stage.hpp, object_vote.hpp, cluster_expand.hpp,
// depth_layers.hpp, temporal_stage.hpp.
struct VoteParams;
struct ObjectVoteParams;
struct ClusterExpandParams;
struct DepthLayersParams;
struct TemporalParams;

/// Wraps a filter. `path` names it in errors and reports; empty: the filter's name.
StagePtr stage(std::unique_ptr<Filter> filter, std::string path = "");
/// A stage with a new filter of type F. Throws ConfigError for invalid parameters.
template <class F>
StagePtr stage(typename F::Params params = typename F::Params()) {
  return stage(std::make_unique<F>(std::move(params)), F::kName);
}

namespace detail {

StagePtr sequence_of(std::vector<StagePtr> members);
StagePtr any_of(std::vector<StagePtr> members);
StagePtr all_of(std::vector<StagePtr> members);
StagePtr first_available_of(std::vector<StagePtr> members);
StagePtr vote_of(const VoteParams& params, std::vector<StagePtr> members);

template <class... S>
std::vector<StagePtr> stages(S&&... members) {
  std::vector<StagePtr> result;
  (result.push_back(std::forward<S>(members)), ...);
  return result;
}

}  // namespace detail

/// The combinators of pipeline/combinator_table.hpp with these stages as children.
/// `negate` is `not` in YAML; `condition` and `otherwise` are `if` and `else`.
template <class... S>
StagePtr sequence(S&&... members) {
  return detail::sequence_of(detail::stages(std::forward<S>(members)...));
}
template <class... S>
StagePtr first_available(S&&... members) {
  return detail::first_available_of(detail::stages(std::forward<S>(members)...));
}
template <class... S>
StagePtr any(S&&... members) {
  return detail::any_of(detail::stages(std::forward<S>(members)...));
}
template <class... S>
StagePtr all(S&&... members) {
  return detail::all_of(detail::stages(std::forward<S>(members)...));
}
/// Throws ConfigError if weights are given, but not one per member.
template <class... S>
StagePtr vote(const VoteParams& params, S&&... members) {
  return detail::vote_of(params, detail::stages(std::forward<S>(members)...));
}
StagePtr negate(StagePtr member);  ///< dynamic and static exchanged
StagePtr strict(StagePtr member);  ///< unknown becomes dynamic
/// `then` judges what `condition` calls dynamic, `otherwise` what it calls static; null: nothing does.
StagePtr gate(StagePtr condition, StagePtr then, StagePtr otherwise = nullptr);
StagePtr by_region(StagePtr inside, StagePtr outside);              ///< `inside` judges prior suspects
StagePtr object_vote(const ObjectVoteParams& params, StagePtr of);  ///< an object's features decide together
StagePtr cluster_expand(const ClusterExpandParams& params, StagePtr of);  ///< with the cluster around it
StagePtr depth_layers(const DepthLayersParams& params, StagePtr of);      ///< by layers of depth in a box
StagePtr temporal(const TemporalParams& params, StagePtr of);             ///< by the votes of several frames

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/pipeline/detail/compose-inl.hpp>
#endif
