// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <dynfilter/config/near_miss.hpp>
#include <dynfilter/config/numbers.hpp>
#include <dynfilter/config/text_lines.hpp>
#include <dynfilter/core/error.hpp>
#include <dynfilter/keyframe/frame_summary.hpp>
#include <dynfilter/keyframe/make_selector.hpp>
#include <dynfilter/keyframe/pose_change.hpp>
#include <dynfilter/keyframe/selector.hpp>
#include <dynfilter/keyframe/vertex_cover_selector.hpp>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "map_output.hpp"

namespace dynfilter::command {

/// Selects the frames that a map is built from.
/// The rule is `own` (the front end's keyframes), `every:N`, or a selector of keyframe/.
/// Frames are buffered here until the decision.
class MapKeyframes {
 public:
  using Take = std::function<void(const MapInput&)>;

  /// Throws ConfigError for an unknown rule.
  explicit MapKeyframes(const std::string& rule) : rule_(rule) {
    if (rule == "own") return;
    if (rule.rfind("every:", 0) == 0) {
      const auto n = io::parse_number(rule.substr(6));
      every_ = n && *n >= 1 && *n <= 1e6 ? static_cast<std::size_t>(*n) : 0;
      if (every_ == 0 || static_cast<double>(every_) != *n)
        throw ConfigError("", "--keyframes " + rule + ": expected every:N with N a whole number from 1");
      return;
    }
    if (rule != PoseChangeSelector::kName && rule != VertexCoverSelector::kName)
      throw ConfigError("", "--keyframes: " + unknown_name("rule", rule,
                                                           {"own", "every:N", PoseChangeSelector::kName,
                                                            VertexCoverSelector::kName}));
    selector_ = make_keyframe_selector(rule);
  }

  const std::string& rule() const { return rule_; }

  /// Passes on the keyframes that are decided with this frame, in order.
  /// `own`: the front end made it a keyframe.
  void add(MapInput input, const FrameSummary& summary, bool own, const Take& take) {
    const std::int64_t id = input.frame.id;
    waiting_.push_back(std::move(input));
    if (selector_)
      mark(selector_->add(summary));
    else
      waiting_.back().keyframe = every_ > 0 ? frames_ % every_ == 0 : own;
    ++frames_;
    const std::vector<std::int64_t> open = selector_ ? selector_->pending() : std::vector<std::int64_t>();
    release(open.empty() ? id + 1 : *std::min_element(open.begin(), open.end()), take);
  }

  /// Call at the end. Passes on the remaining keyframes.
  void flush(const Take& take) {
    if (selector_) mark(selector_->flush());
    if (!waiting_.empty()) release(waiting_.back().frame.id + 1, take);
  }

 private:
  void mark(const std::vector<SelectedFrame>& chosen) {
    for (const SelectedFrame& key : chosen)
      for (MapInput& input : waiting_) input.keyframe = input.keyframe || input.frame.id == key.id;
  }
  void release(std::int64_t before, const Take& take) {
    while (!waiting_.empty() && waiting_.front().frame.id < before) {
      take(waiting_.front());
      waiting_.pop_front();
    }
  }

  std::string rule_;
  std::size_t every_ = 0, frames_ = 0;
  std::unique_ptr<KeyframeSelector> selector_;
  std::deque<MapInput> waiting_;
};

}  // namespace dynfilter::command
