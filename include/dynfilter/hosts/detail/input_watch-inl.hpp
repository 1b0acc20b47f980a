// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/hosts/input_watch.hpp>

#include <algorithm>
#include <dynfilter/core/inline.hpp>
#include <dynfilter/evidence/semantic_input.hpp>
#include <dynfilter/pipeline/routing_stages.hpp>
#include <dynfilter/pipeline/stage.hpp>

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
    line += in_brackets(how_to_give(missing)) + optional_inputs(missing) + choices(given);
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
  for (Asked& asked : asked_) {
    if (asked.point != point) continue;
    asked.missing = without(asked.missing, inputs);
    for (const StageReport& stage : report.stages) {
      if (stage.path != asked.path || stage.name != asked.stage) continue;
      asked.judged = asked.judged || stage.has_judged();
      asked.note = stage.note;
    }
  }
}

DYNFILTER_INLINE std::string InputWatch::take_warning() {
  if (done_ || frames_ < kPatience) return "";
  done_ = true;
  const std::string missing = missing_inputs(), calls = missing_calls();
  if (missing.empty() && calls.empty()) return "";
  std::string line = "pipeline `" + name_ + "`: in " + std::to_string(kPatience) + " frames ";
  line += missing + (missing.empty() || calls.empty() ? "" : ", and ") + calls;
  if (!rejected_) line += "; nothing was rejected";
  return line + "; " + judges() + in_brackets(how_to_give(never_given()));
}

inline void InputWatch::collect(CallPoint point, const Stage& root) {
  Nodes nodes;
  root.for_each([&](const Stage& stage, int depth) { nodes.emplace_back(&stage, depth); });
  const bool routes_suspects = std::any_of(nodes.begin(), nodes.end(), [](const auto& node) {
    return dynamic_cast<const ByRegionStage*>(node.first) != nullptr;
  });
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const Stage& stage = *nodes[i].first;
    Input inputs = stage.needs().required | (stage.needs().optional & kSemantic);
    for (std::size_t k = i + 1; k < nodes.size() && nodes[k].second > nodes[i].second; ++k)
      inputs = without(inputs, nodes[k].first->needs().required | nodes[k].first->needs().optional);
    if (only_marks(stage) && !routes_suspects) inputs = Input::None;
    const bool fallback = has_fallback(nodes, i);
    asked_for_ = asked_for_ | stage.needs().required | stage.needs().optional;
    asked_.push_back({point, stage.name(), stage.path(), fallback ? Input::None : inputs,
                      fallback ? inputs : Input::None, inputs,
                      dynamic_cast<const FilterStage*>(&stage) != nullptr});
  }
  collect_choices(nodes);
}

inline void InputWatch::collect_choices(const Nodes& nodes) {
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (dynamic_cast<const FirstAvailableStage*>(nodes[i].first) == nullptr) continue;
    for (std::size_t k = i + 1; k < nodes.size() && nodes[k].second > nodes[i].second; ++k)
      if (nodes[k].second == nodes[i].second + 1)
        members_.push_back({choices_, nodes[k].first->name(), nodes[k].first->needs().required});
    ++choices_;
  }
}

/// Without its inputs, a later member of `first_available` judges.
inline bool InputWatch::has_fallback(const Nodes& nodes, std::size_t i) {
  std::size_t parent = i, later = i + 1;
  while (parent > 0 && nodes[parent].second >= nodes[i].second) --parent;
  while (later < nodes.size() && nodes[later].second > nodes[i].second) ++later;
  const bool is_last = later == nodes.size() || nodes[later].second < nodes[i].second;
  return !is_last && dynamic_cast<const FirstAvailableStage*>(nodes[parent].first) != nullptr;
}

inline bool InputWatch::only_marks(const Stage& stage) {
  const auto* filter = dynamic_cast<const FilterStage*>(&stage);
  if (filter == nullptr) return false;
  const auto* semantic = dynamic_cast<const SemanticFilter*>(&filter->filter());
  return semantic != nullptr && semantic->role() == SemanticRole::Prior;
}

inline bool InputWatch::has_stages(CallPoint point) const {
  for (const Asked& asked : asked_)
    if (asked.point == point) return true;
  return false;
}

inline bool InputWatch::any_judged() const {
  return std::any_of(asked_.begin(), asked_.end(), [](const Asked& asked) { return asked.judged; });
}

inline Input InputWatch::never_given(const Asked& asked) const {
  if (!called_[index(asked.point)]) return Input::None;
  return asked.missing & (any_judged() ? asked.needed : asked.needed | asked.replaceable);
}

inline Input InputWatch::never_given() const {
  Input inputs = Input::None;
  for (const Asked& asked : asked_) inputs = inputs | never_given(asked);
  return inputs;
}

inline std::string InputWatch::optional_inputs(Input missing) const {
  for (const Asked& asked : asked_) missing = without(missing, asked.needed);
  const Input optional = missing & kSemantic;
  if (optional == Input::None) return "";
  const bool both = optional == kSemantic;
  return "; " + with_commas_as(" and ", to_string(optional)) +
         (both || optional == Input::Detections ? " are" : " is") + " optional";
}

inline std::string InputWatch::choices(Input given) const {
  std::string text;
  for (std::size_t choice = 0; choice < choices_; ++choice) {
    Input lacking = Input::None;
    std::string passed_over;
    for (const Member& member : members_) {
      if (member.choice != choice) continue;
      const Input lacks = without(member.required, given);
      if (lacks == Input::None) {
        if (!passed_over.empty())
          text += "; without " + to_string(lacking) + " " + member.stage + " judges, not " + passed_over;
        break;
      }
      lacking = lacking | lacks;
      passed_over += (passed_over.empty() ? "" : ", ") + member.stage;
    }
  }
  return text;
}

inline std::string InputWatch::missing_inputs() const {
  const Input missing = never_given();
  if (missing == Input::None) return "";
  std::string stages;
  for (const Asked& asked : asked_) {
    const bool lacks = never_given(asked) != Input::None;
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

inline std::string InputWatch::judges() const {
  std::string judged, notes;
  for (const Asked& asked : asked_) {
    if (!asked.is_filter || !called_[index(asked.point)]) continue;
    std::string& list = asked.judged ? judged : notes;
    if (asked.judged && (", " + list + ", ").find(", " + asked.stage + ", ") != std::string::npos) continue;
    list += (list.empty() ? "" : ", ") + asked.stage;
    if (!asked.judged && !asked.note.empty()) list += ": " + asked.note;
  }
  return judged.empty() ? "no stage judged" + in_brackets(notes)
                        : "judged by " + with_commas_as(" and ", judged);
}

inline std::string InputWatch::with_commas_as(const std::string& word, std::string list) {
  for (std::size_t at = list.find(", "); at != std::string::npos; at = list.find(", ", at + word.size()))
    list.replace(at, 2, word);
  return list;
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
