// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/config/parameters.hpp>

namespace dynfilter {

/// What boxes and masks do in a frame that has no earlier one to compare with.
enum class FirstFrameSuspects {
  Keep,   ///< as in any other frame: a prior suspect stays until a stage says that it moves
  Reject  ///< what a semantic stage suspects is dynamic, unless the pipeline calls it static
};

struct PipelineParams {
  double max_time_gap_s = 2.0;
  FirstFrameSuspects first_frame_suspects = FirstFrameSuspects::Keep;
  double budget_ms = 0;  ///< 0: none

  static const FieldTable<PipelineParams>& fields();
};

/// How many features must be kept, so that the tracker has enough.
struct FloorParams {
  int min_features = 50;         ///< absolute count
  double min_share = 0;          ///< share of the frame's features
  double min_grid_coverage = 0;  ///< share of the occupied grid cells that must keep a feature
  int grid_rows = 6;             ///< Rows of the grid. Not a key: code sets it.
  int grid_columns = 8;          ///< Columns of the grid. Not a key: code sets it.
  bool restore_all = false;      ///< keep all features when the floor is reached, instead of just enough

  static const FieldTable<FloorParams>& fields();
};

/// When a host may create its first keyframe in a scene with moving objects.
struct InitialisationParams {
  double max_dynamic_share = 0.3;
  int max_frames = 0;

  static const FieldTable<InitialisationParams>& fields();
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/pipeline/detail/pipeline_params-inl.hpp>
#endif
