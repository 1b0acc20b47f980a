// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/pipeline/pipeline_params.hpp>

#include <dynfilter/core/inline.hpp>

namespace dynfilter {

DYNFILTER_INLINE const FieldTable<PipelineParams>& PipelineParams::fields() {
  static const FieldTable<PipelineParams> table{
      real("max_time_gap_s", &PipelineParams::max_time_gap_s, "s", {0, 1e9},
           "longest time between two frames; a longer gap, or time going backwards, resets the pipeline"),
      choice("first_frame_suspects", &PipelineParams::first_frame_suspects,
             {{"keep", FirstFrameSuspects::Keep}, {"reject", FirstFrameSuspects::Reject}},
             "features on boxes and masks of the first frame, and of the first after a reset"),
      real("budget_ms", &PipelineParams::budget_ms, "ms", {0, 1e6},
           "time of a call after which no further rejector starts; 0: no limit"),
  };
  return table;
}

DYNFILTER_INLINE const FieldTable<FloorParams>& FloorParams::fields() {
  using P = FloorParams;
  static const FieldTable<P> table{
      integer("min_features", &P::min_features, "features", {0, 100000},
              "smallest number of features to keep"),
      real("min_share", &P::min_share, "", {0, 1}, "smallest share of the frame's features to keep"),
      real("min_grid_coverage", &P::min_grid_coverage, "", {0, 1},
           "smallest share of the occupied grid cells that keep a feature"),
      flag("restore_all", &P::restore_all, "keep all features when the floor is reached, as SG-SLAM does"),
  };
  return table;
}

DYNFILTER_INLINE const FieldTable<InitialisationParams>& InitialisationParams::fields() {
  using P = InitialisationParams;
  static const FieldTable<P> table{
      real("max_dynamic_share", &P::max_dynamic_share, "", {0, 1},
           "largest share of dynamic features, among those judged, at which the first keyframe is created"),
      integer("max_frames", &P::max_frames, "frames", {0, 100000},
              "longest delay of the first keyframe; 0: no delay"),
  };
  return table;
}

}  // namespace dynfilter
