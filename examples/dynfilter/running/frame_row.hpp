// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <dynfilter/core/votes.hpp>
#include <opencv2/core.hpp>
#include <string>

#include "eval/classification.hpp"
#include "odometry/track_result.hpp"
#include "pipeline_judge.hpp"
#include "run_summary.hpp"

namespace dynfilter::command {

/// What is known of a frame once it was processed, without a truth.
inline FrameRow frame_row(std::size_t index, double timestamp_s, const odometry::TrackResult& result,
                          const FrameVerdict& verdict) {
  FrameRow row;
  row.index = index;
  row.timestamp_s = timestamp_s;
  row.state = odometry::to_string(result.state);
  row.keyframe = result.keyframe, row.relocalised = result.relocalised;
  row.features = verdict.features.size();
  row.of_static = verdict.count(Vote::Static), row.dynamic = verdict.count(Vote::Dynamic);
  row.unknown = verdict.count(Vote::Unknown), row.restored = verdict.restored();
  row.weight_mean = verdict.mean_weight();
  row.tracked_points = static_cast<std::size_t>(result.tracked_points);
  row.extraction_ms = result.ms.extraction;
  row.correspondence_ms = verdict.correspondence_ms;
  row.filters_ms = std::max(0.0, result.ms.judge - verdict.correspondence_ms);
  row.tracking_ms = result.ms.tracking + result.ms.mapping;
  row.cpu_ms = result.cpu_ms.total(), row.cpu_judge_ms = result.cpu_ms.judge;
  for (const auto* notes : {&verdict.stage_notes, &verdict.notes})
    for (const std::string& note : *notes) row.note += (row.note.empty() ? "" : "; ") + note;
  return row;
}

/// `truth`: 0 static, 128 don't care, 255 dynamic.
inline eval::Classification judged(const FrameVerdict& verdict, const cv::Mat& truth) {
  eval::Classification counts;
  for (const MarkedFeature& f : verdict.features)
    counts.add(eval::truth_at(truth, f.pixel), f.decision == Vote::Dynamic);
  return counts;
}

}  // namespace dynfilter::command
