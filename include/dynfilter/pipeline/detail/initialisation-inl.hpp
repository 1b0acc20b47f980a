// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/pipeline/initialisation.hpp>

#include <cstddef>
#include <dynfilter/core/inline.hpp>
#include <dynfilter/core/votes.hpp>

namespace dynfilter {

DYNFILTER_INLINE void Initialisation::apply(Verdict& verdict) {
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
