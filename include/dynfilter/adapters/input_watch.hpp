// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <dynfilter/core/needs.hpp>
#include <dynfilter/core/verdict.hpp>
#include <dynfilter/pipeline/pipeline.hpp>
#include <dynfilter/pipeline/stage.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace dynfilter {

/// Which inputs a pipeline uses and which a host gives: for one line at start, and for one warning
/// when something never came.
class InputWatch {
 public:
  static constexpr int kPatience = 30;  ///< frames

  explicit InputWatch(const Pipeline& pipeline);

  /// Which pipeline runs, from which file, which inputs it uses and which are given: "dynfilter: pipeline
  /// `des_slam` of .../des_slam.yaml uses depth, mask; the host gives depth, but not: mask". `given`:
  /// what the host can give.
  std::string start_line(const std::string& file, Input given) const;

  /// After every call of the pipeline. `rejected`: features that it called dynamic.
  void saw(const FrameReport& report, Input inputs, std::size_t rejected);

  /// One line when, after kPatience frames, a stage has never got one of its inputs; "" before, afterwards,
  /// and when nothing is missing.
  std::string take_warning();

 private:
  static constexpr std::array<CallPoint, 3> kPoints{CallPoint::BeforePose, CallPoint::AfterPose,
                                                    CallPoint::AtKeyframe};
  static constexpr Input kSemantic = Input::Detections | Input::Mask;

  struct Asked {
    CallPoint point;
    std::string stage;
    Input inputs, missing;
  };

  static std::size_t index(CallPoint point) { return static_cast<std::size_t>(point); }

  /// Of each stage what it requires, and boxes and masks even where it can do without. A combinator reports
  /// its members' inputs as its own. Only what none of them uses is its own.
  void collect(CallPoint point, const Stage& root);

  static bool has_fallback(const std::vector<std::pair<const Stage*, int>>& nodes, std::size_t i);
  bool has_stages(CallPoint point) const;
  Input never_given() const;

  /// "no mask came (semantic_mask, object_vote)"
  std::string missing_inputs() const;
  std::string missing_calls() const;

  static std::string with_commas_as(const std::string& word, std::string list);
  static std::string in_brackets(const std::string& text);
  static std::string how_to_give(Input missing);

  std::string name_;
  Input asked_for_ = Input::None;
  std::vector<Asked> asked_;
  std::array<bool, 3> called_{};
  int frames_ = 0;
  std::optional<std::int64_t> last_id_;
  bool rejected_ = false, done_ = false;
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/adapters/detail/input_watch-inl.hpp>
#endif
