// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <dynfilter/pipeline/pipeline.hpp>
#include <optional>
#include <utility>

namespace dynfilter {

class Stage;

/// Which inputs a pipeline uses and which a host gives. It makes one line at start, and one warning if a
/// needed input never came. An input of a `first_available` member is not needed while a later member judges.
/// Boxes or masks that only mark suspects are needed only if `by_region` routes suspects.
class InputWatch {
 public:
  static constexpr int kPatience = 30;  ///< frames

  explicit InputWatch(const Pipeline& pipeline);  ///< refers to the pipeline, which must outlive it

  /// Which pipeline runs, from which file, which inputs it uses, which are given, and which stage judges
  /// without the others:
  /// "dynfilter: pipeline `des_slam` of .../des_slam.yaml uses depth, mask; the host gives depth, but not:
  /// mask". `given`: what the host can give.
  std::string start_line(const std::string& file, Input given) const;

  /// After every call of the pipeline. `rejected`: features that it called dynamic.
  void saw(const FrameReport& report, Input inputs, std::size_t rejected);

  /// One line when, after kPatience frames, a stage has never got an input that it needs. It says which
  /// stages judged, and whether anything was rejected. "" before, afterwards, and when nothing is missing.
  std::string take_warning();

 private:
  static constexpr std::array<CallPoint, 3> kPoints{CallPoint::BeforePose, CallPoint::AfterPose,
                                                    CallPoint::AtKeyframe};
  static constexpr Input kSemantic = Input::Detections | Input::Mask;
  using Nodes = std::vector<std::pair<const Stage*, int>>;  ///< in file order, with their depth

  struct Asked {
    CallPoint point;
    std::string stage, path;
    Input needed, replaceable;  ///< replaceable: a later member of `first_available` judges without it
    Input missing;              ///< of both, never given so far
    bool is_filter, judged = false;
    std::string note{};  ///< the last one
  };
  /// A member of `first_available`.
  struct Member {
    std::size_t choice;  ///< number of its `first_available`
    std::string stage;
    Input required;
  };

  static std::size_t index(CallPoint point) { return static_cast<std::size_t>(point); }

  /// Of each stage what it requires, and boxes and masks even where it can do without. A combinator reports
  /// its members' inputs as its own. Only what none of them uses is its own.
  void collect(CallPoint point, const Stage& root);
  void collect_choices(const Nodes& nodes);
  static bool has_fallback(const Nodes& nodes, std::size_t i);
  static bool only_marks(const Stage& stage);
  bool has_stages(CallPoint point) const;
  bool any_judged() const;
  Input never_given(const Asked& asked) const;
  Input never_given() const;

  std::string optional_inputs(Input missing) const;  ///< "; boxes and mask are optional"
  /// "; without depth flow_consistency judges, not background_motion"
  std::string choices(Input given) const;
  std::string missing_inputs() const;  ///< "no mask came for semantic_mask and object_vote"
  std::string missing_calls() const;
  /// "judged by flow_consistency", or that no stage judged and what the stages said.
  std::string judges() const;

  static std::string with_commas_as(const std::string& word, std::string list);
  static std::string in_brackets(const std::string& text);
  static std::string how_to_give(Input missing);

  std::string name_;
  Input asked_for_ = Input::None;
  std::vector<Asked> asked_;
  std::vector<Member> members_;
  std::size_t choices_ = 0;
  std::array<bool, 3> called_{};
  int frames_ = 0;
  std::optional<std::int64_t> last_id_;
  bool rejected_ = false, done_ = false;
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/hosts/detail/input_watch-inl.hpp>
#endif
