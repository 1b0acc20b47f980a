// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <dynfilter/core/verdict.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/pipeline/pipeline_params.hpp>
#include <optional>

namespace dynfilter {

/// Delays the first keyframe until few features are dynamic (Zhou et al. sec. 3.1.3). The first frames are
/// judged too. A frame without any verdict also delays it. The first frame has none, as it has no reference.
class Initialisation {
 public:
  explicit Initialisation(const InitialisationParams& params = InitialisationParams()) : params_(params) {}

  void reset() { started_ = false, waited_ = 0, last_frame_.reset(); }
  /// Call when the host has created a keyframe. This ends the delay.
  void keyframe_made() { started_ = true; }

  /// Sets report.wait_for_keyframe. Features that the floor restored count as dynamic.
  void apply(Verdict& verdict);

 private:
  InitialisationParams params_;
  bool started_ = false;
  int waited_ = 0;
  std::optional<std::int64_t> last_frame_;
};

inline void Initialisation::apply(Verdict& verdict) {
  verdict.report.wait_for_keyframe = false;
  if (params_.max_frames == 0 || started_) return;
  if (last_frame_ != verdict.report.frame_id) {
    last_frame_ = verdict.report.frame_id;
    ++waited_;
  }
  if (waited_ > params_.max_frames) return;
  std::size_t judged = 0, dynamic = 0;
  for (std::size_t i = 0; i < verdict.size(); ++i) {
    const bool moves = verdict.decision[i] == Vote::Dynamic || verdict.restored[i] != 0;
    dynamic += moves ? 1U : 0U;
    judged += moves || verdict.decision[i] == Vote::Static ? 1U : 0U;
  }
  verdict.report.wait_for_keyframe =
      judged == 0 || static_cast<double>(dynamic) > params_.max_dynamic_share * static_cast<double>(judged);
  if (verdict.report.wait_for_keyframe)
    verdict.report.notes.push_back("initialisation: the first keyframe is delayed");
}

}  // namespace dynfilter
