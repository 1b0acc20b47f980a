// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/adapters/input_watch.hpp>

#include <dynfilter/core/inline.hpp>
#include <dynfilter/pipeline/routing_stages.hpp>
#include <utility>

namespace dynfilter {

DYNFILTER_INLINE InputWatch::InputWatch(const Pipeline& pipeline) : name_(pipeline.name()) {
  for (const CallPoint point : kPoints)
    if (const Stage* root = pipeline.stages(point)) collect(point, *root);
}

DYNFILTER_INLINE std::string InputWatch::start_line(const std::string& file, Input given) const {
  std::string line = "dynfilter: pipeline `" + name_ + "`";
  if (!file.empty()) line += " of " + file;
  line += " uses " + to_string(asked_for_);
  const Input missing = without(asked_for_, given);
  if (asked_for_ != Input::None && missing == Input::None) line += "; the host gives all of it";
  if (missing != Input::None) {
    line += "; the host gives " + to_string(asked_for_ & given) + ", but not: " + to_string(missing);
    line += in_brackets(how_to_give(missing));
  }
  std::string calls;
  for (const CallPoint point : {CallPoint::AfterPose, CallPoint::AtKeyframe})
    if (has_stages(point)) calls += (calls.empty() ? "" : ", ") + std::string(to_string(point)) + "()";
  return calls.empty() ? line : line + "; it also needs the calls " + calls;
}

DYNFILTER_INLINE void InputWatch::saw(const FrameReport& report, Input inputs, std::size_t rejected) {
  if (done_) return;
  const CallPoint point = report.call_point;
  frames_ += last_id_ == report.frame_id ? 0 : 1;
  last_id_ = report.frame_id;
  called_[index(point)] = true;
  rejected_ = rejected_ || rejected > 0;
  for (Asked& asked : asked_)
    if (asked.point == point) asked.missing = without(asked.missing, inputs);
}

DYNFILTER_INLINE std::string InputWatch::take_warning() {
  if (done_ || frames_ < kPatience) return "";
  done_ = true;
  const std::string missing = missing_inputs(), calls = missing_calls();
  if (missing.empty() && calls.empty()) return "";
  std::string line = "pipeline `" + name_ + "`: in " + std::to_string(kPatience) + " frames ";
  line += missing + (missing.empty() || calls.empty() ? "" : ", and ") + calls;
  line += rejected_ ? "; the other stages judge without" : "; nothing was rejected";
  return line + in_brackets(how_to_give(never_given()));
}

inline void InputWatch::collect(CallPoint point, const Stage& root) {
  std::vector<std::pair<const Stage*, int>> nodes;
  root.for_each([&](const Stage& stage, int depth) { nodes.emplace_back(&stage, depth); });
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    Input inputs = nodes[i].first->needs().required | (nodes[i].first->needs().optional & kSemantic);
    for (std::size_t k = i + 1; k < nodes.size() && nodes[k].second > nodes[i].second; ++k)
      inputs = without(inputs, nodes[k].first->needs().required | nodes[k].first->needs().optional);
    if (has_fallback(nodes, i)) inputs = Input::None;
    asked_for_ = asked_for_ | nodes[i].first->needs().required | nodes[i].first->needs().optional;
    asked_.push_back({point, nodes[i].first->name(), inputs, inputs});
  }
}

/// Without its inputs, a later member of `first_available` judges.
inline bool InputWatch::has_fallback(const std::vector<std::pair<const Stage*, int>>& nodes, std::size_t i) {
  std::size_t parent = i, later = i + 1;
  while (parent > 0 && nodes[parent].second >= nodes[i].second) --parent;
  while (later < nodes.size() && nodes[later].second > nodes[i].second) ++later;
  const bool is_last = later == nodes.size() || nodes[later].second < nodes[i].second;
  return !is_last && dynamic_cast<const FirstAvailableStage*>(nodes[parent].first) != nullptr;
}

inline bool InputWatch::has_stages(CallPoint point) const {
  for (const Asked& asked : asked_)
    if (asked.point == point) return true;
  return false;
}

inline Input InputWatch::never_given() const {
  Input inputs = Input::None;
  for (const Asked& asked : asked_)
    if (called_[index(asked.point)]) inputs = inputs | asked.missing;
  return inputs;
}

inline std::string InputWatch::with_commas_as(const std::string& word, std::string list) {
  for (std::size_t at = list.find(", "); at != std::string::npos; at = list.find(", ", at + word.size()))
    list.replace(at, 2, word);
  return list;
}

inline std::string InputWatch::missing_inputs() const {
  const Input missing = never_given();
  if (missing == Input::None) return "";
  std::string stages;
  for (const Asked& asked : asked_) {
    const bool lacks = called_[index(asked.point)] && asked.missing != Input::None;
    if (lacks && (", " + stages + ", ").find(", " + asked.stage + ", ") == std::string::npos)
      stages += (stages.empty() ? "" : ", ") + asked.stage;
  }
  return "no " + with_commas_as(" and no ", to_string(missing)) + " came for " +
         with_commas_as(" and ", stages);
}

inline std::string InputWatch::missing_calls() const {
  std::string calls;
  for (const CallPoint point : kPoints)
    if (has_stages(point) && !called_[index(point)])
      calls += (calls.empty() ? "" : " nor ") + std::string(to_string(point)) + "()";
  return calls.empty() ? "" : calls + " was never called";
}

inline std::string InputWatch::in_brackets(const std::string& text) {
  return text.empty() ? "" : " (" + text + ")";
}

inline std::string InputWatch::how_to_give(Input missing) {
  std::string hint;
  const auto add = [&](Input input, const char* text) {
    if ((missing & input) != Input::None) hint += (hint.empty() ? "" : "; ") + std::string(text);
  };
  add(Input::Detections, "boxes: set_detections(), DynFilter.boxes or DynFilter.detector");
  add(Input::Mask, "masks: set_mask(), DynFilter.masks or DynFilter.detector");
  return hint;
}

}  // namespace dynfilter
