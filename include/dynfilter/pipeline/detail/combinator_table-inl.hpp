// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/pipeline/combinator_table.hpp>

#include <dynfilter/core/inline.hpp>
#include <dynfilter/pipeline/cluster_expand.hpp>
#include <dynfilter/pipeline/depth_layers.hpp>
#include <dynfilter/pipeline/logic_stages.hpp>
#include <dynfilter/pipeline/object_vote.hpp>
#include <dynfilter/pipeline/routing_stages.hpp>
#include <dynfilter/pipeline/temporal_stage.hpp>
#include <dynfilter/pipeline/vote_stage.hpp>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace dynfilter {

namespace detail {

inline CombinatorCard combinator_card(const char* name, std::string form, const char* summary,
                                      const char* dynamic) {
  return {name, std::move(form), summary, dynamic, {}};
}
template <class S>
CombinatorCard combinator_card(std::string form) {
  return combinator_card(S::kName, std::move(form), S::kSummary, S::kDynamic);
}

/// `{ key: stage, ... }`
inline std::string form_of_keys(const std::vector<std::string>& keys,
                                const std::vector<std::string>& optional) {
  std::string form;
  for (const auto* names : {&keys, &optional})
    for (const std::string& name : *names) form += (form.empty() ? "{ " : ", ") + name + ": stage";
  return form + " }";
}

inline Stages one_stage(const YamlNode& value, const StageReader& reader) {
  Stages stages;
  stages.push_back(reader.stage(value));
  return stages;
}

inline Stages stages_of_keys(const YamlNode& value, const StageReader& reader,
                             const std::vector<std::string>& keys, const std::vector<std::string>& optional) {
  Stages stages;
  for (const YamlNode& node : StageReader::nodes(value, keys, optional)) stages.push_back(reader.stage(node));
  return stages;
}

/// The stages after `of`.
inline Stages members(const YamlNode& value, const StageReader& reader, bool list) {
  const YamlNode of = StageReader::required(value, "of");
  return list ? reader.stages(of) : one_stage(of, reader);
}

/// `name: [stage, ...]`
template <class S>
CombinatorEntry of_a_list() {
  return {combinator_card<S>("[stage, ...]"), [](const YamlNode& value, const StageReader& reader) {
            return std::make_unique<S>(value.path(), reader.stages(value));
          }};
}

/// `name: stage`
template <class S>
CombinatorEntry of_one() {
  return {combinator_card<S>("stage"), [](const YamlNode& value, const StageReader& reader) {
            return std::make_unique<S>(value.path(), one_stage(value, reader));
          }};
}

/// `name: { key: stage, ... }`
template <class S>
CombinatorEntry of_keys(const std::vector<std::string>& keys, const std::vector<std::string>& optional = {}) {
  return {combinator_card<S>(form_of_keys(keys, optional)),
          [=](const YamlNode& value, const StageReader& reader) {
            return std::make_unique<S>(value.path(), stages_of_keys(value, reader, keys, optional));
          }};
}

/// `name: { of: stage, parameter: ... }`, or a list of members after `of`.
template <class S>
CombinatorEntry of_parameters(bool list = false) {
  CombinatorEntry entry;
  entry.card =
      combinator_card<S>(list ? "{ of: [stage, ...], parameter: ... }" : "{ of: stage, parameter: ... }");
  entry.card.parameters = describe_parameters<typename S::Params>();
  entry.make = [list](const YamlNode& value, const StageReader& reader) {
    const auto params = read_parameters<typename S::Params>(value, {}, {"of"});
    return std::make_unique<S>(value.path(), members(value, reader, list), params);
  };
  return entry;
}

}  // namespace detail

DYNFILTER_INLINE const std::vector<CombinatorEntry>& combinator_table() {
  static const std::vector<CombinatorEntry> table{
      detail::of_a_list<SequenceStage>(),
      detail::of_a_list<AnyStage>(),
      detail::of_a_list<AllStage>(),
      detail::of_one<NotStage>(),
      detail::of_one<StrictStage>(),
      detail::of_keys<GateStage>({"if", "then"}, {"else"}),
      detail::of_keys<ByRegionStage>({"inside", "outside"}),
      detail::of_a_list<FirstAvailableStage>(),
      detail::of_parameters<VoteStage>(true),
      detail::of_parameters<ObjectVoteStage>(),
      detail::of_parameters<ClusterExpandStage>(),
      detail::of_parameters<DepthLayersStage>(),
      detail::of_parameters<TemporalStage>(),
  };
  return table;
}

}  // namespace dynfilter
