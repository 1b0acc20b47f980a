// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <dynfilter/core/frame_view.hpp>
#include <dynfilter/core/votes.hpp>
#include <string>
#include <vector>

namespace dynfilter {

/// The point in the host's frame at which it calls the pipeline.
enum class CallPoint : std::uint8_t {
  BeforePose,  ///< features are extracted, the pose is at most predicted
  AfterPose,   ///< a first pose is estimated, map points are matched
  AtKeyframe,  ///< the frame becomes a keyframe
};

constexpr const char* to_string(CallPoint point) {
  return point == CallPoint::BeforePose  ? "before_pose"
         : point == CallPoint::AfterPose ? "after_pose"
                                         : "at_keyframe";
}

/// Report of one stage on one frame.
struct StageReport {
  std::string name;      ///< the filter's or combinator's name
  std::string path;      ///< position in the pipeline file
  bool skipped = false;  ///< an input was missing; `note` names it
  bool failed = false;   ///< the stage threw; `note` has the message and its votes count as Unknown
  bool doubted = false;  ///< every vote may be Unknown, and that is its judgement; see Votes::doubt()
  std::string note;      ///< e.g. the model that was used or the reason for a skip
  /// Features that it was to judge; of them, votes Dynamic and Unknown; prior suspects that it marked.
  std::size_t judged = 0, dynamic = 0, unknown = 0, prior = 0;
  double time_ms = 0;  ///< includes shared evidence that this stage was the first to request

  /// False if it abstained on the whole frame: it was skipped, failed, or left all Unknown without a doubt.
  bool has_judged() const { return !skipped && !failed && (doubted || judged > unknown); }
};

/// Report of one call of the pipeline.
struct FrameReport {
  std::int64_t frame_id = -1;
  CallPoint call_point = CallPoint::BeforePose;
  std::vector<StageReport> stages;  ///< in the order of the pipeline file, children after their combinator
  std::vector<std::string> notes;   ///< floor events, resets and inputs that could not be used
  std::size_t features = 0, rejected = 0, restored = 0;
  /// Delay the first keyframe: too much moves, or no feature could be judged yet. See InitialisationParams.
  bool wait_for_keyframe = false;
  std::size_t doubts = 0;        ///< resets by the self-check so far, this call included
  double correspondence_ms = 0;  ///< time to find correspondences
  double total_ms = 0;           ///< total time, correspondences included
};

/// Verdict on one map point.
struct MapPointVerdict {
  std::int64_t map_point_id = -1;
  Vote vote = Vote::Unknown;
  float suspicion = Votes::kNoIdea;
};

/// Result per feature: decision, suspicion and the stages behind it. Unknown counts as kept.
struct Verdict {
  std::vector<Vote> decision;
  std::vector<float> suspicion;
  std::vector<std::uint8_t> prior;     ///< 1: a semantic stage marked the feature as a suspect
  std::vector<std::uint8_t> restored;  ///< 1: judged dynamic but restored by the floor, decision Unknown
  std::vector<std::uint64_t> reasons;  ///< bit k: report.stages[k] voted dynamic
  std::vector<MatchSpread> spread;     ///< of the match with the last frame; empty: no stage asked for it
  /// At a keyframe, one entry per feature with a map point: of the stage there, or of all frames.
  std::vector<MapPointVerdict> map_points;
  FrameReport report;

  std::size_t size() const { return decision.size(); }
  bool keep(std::size_t i) const { return decision[i] != Vote::Dynamic; }  ///< everything but Dynamic
  bool called_dynamic(std::size_t i) const { return !keep(i) || restored[i] != 0; }  ///< before the floor
  /// For the host's optimiser: what to multiply the feature's information (1 / sigma^2) with, in [0, 1]. The
  /// probability that it stands still, times how well its match is determined in the worst direction. The
  /// suspicion s of a distance d with the limit l is d / (d + l); the probability is 1 / (1 + (d / l)^2).
  float weight(std::size_t i) const;
  std::size_t kept() const;  ///< number of features that stay
  /// Names of the stages that voted feature i dynamic, e.g. "epipolar+trajectory_consistency".
  /// "" if none did.
  std::string reason(std::size_t i) const;
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/core/detail/verdict-inl.hpp>
#endif
