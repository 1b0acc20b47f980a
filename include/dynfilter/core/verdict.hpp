// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <dynfilter/core/votes.hpp>
#include <string>
#include <vector>

namespace dynfilter {

/// Where in the host's frame the pipeline is called.
enum class CallPoint : std::uint8_t {
  BeforePose,  ///< features are there, the pose is at most predicted
  AfterPose,   ///< a first pose is estimated, map points are matched
  AtKeyframe,  ///< the frame becomes a keyframe
};

constexpr const char* to_string(CallPoint point) {
  return point == CallPoint::BeforePose  ? "before_pose"
         : point == CallPoint::AfterPose ? "after_pose"
                                         : "at_keyframe";
}

/// What one stage did with one frame.
struct StageReport {
  std::string name;      ///< the filter's or combinator's name
  std::string path;      ///< where it stands in the pipeline file
  bool skipped = false;  ///< an input was missing: see note
  bool failed = false;   ///< it threw: see note; its votes count as Unknown
  std::string note;      ///< which model was used, why it was skipped, ...
  std::size_t judged = 0, dynamic = 0, unknown = 0, prior = 0;
  double time_ms = 0;  ///< the shared evidence that it was first to ask for included
};

struct FrameReport {
  std::int64_t frame_id = -1;
  CallPoint call_point = CallPoint::BeforePose;
  std::vector<StageReport> stages;  ///< in the order of the pipeline file, children after their combinator
  std::vector<std::string> notes;   ///< floor events, resets, inputs that could not be used
  std::size_t features = 0, rejected = 0, restored = 0;
  /// Before the first keyframe: wait with it, too much moves or nothing could be judged yet
  /// (InitialisationParams).
  bool wait_for_keyframe = false;
  double correspondence_ms = 0;  ///< spent on correspondences
  double total_ms = 0;           ///< everything, correspondences included
};

struct MapPointVerdict {
  std::int64_t map_point_id = -1;
  Vote vote = Vote::Unknown;
  float suspicion = Votes::kNoIdea;
};

/// The answer: per feature what it is, how suspicious, and which stages said so. Unknown counts as kept.
struct Verdict {
  std::vector<Vote> decision;
  std::vector<float> suspicion;
  std::vector<std::uint8_t> prior;          ///< a semantic stage marked it as a suspect
  std::vector<std::uint8_t> restored;       ///< judged dynamic, brought back by the floor (decision Unknown)
  std::vector<std::uint64_t> reasons;       ///< bit k: report.stages[k] called it dynamic
  std::vector<MapPointVerdict> map_points;  ///< at a keyframe, one per feature that has a map point
  FrameReport report;

  std::size_t size() const { return decision.size(); }
  bool keep(std::size_t i) const { return decision[i] != Vote::Dynamic; }
  std::size_t kept() const {
    std::size_t n = 0;
    for (const Vote vote : decision) n += vote != Vote::Dynamic ? 1 : 0;
    return n;
  }
  /// The stages that called feature i dynamic, e.g. "epipolar+trajectory_consistency"; "" if none did.
  std::string reason(std::size_t i) const {
    std::string text;
    for (std::size_t k = 0; k < report.stages.size() && k < 64; ++k)
      if ((reasons[i] >> k & 1U) != 0) text += (text.empty() ? "" : "+") + report.stages[k].name;
    return text;
  }
};

}  // namespace dynfilter
