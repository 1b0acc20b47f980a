// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstddef>
#include <optional>
#include <string>

#include "text/json.hpp"

namespace dynfilter::command {

/// `--truth`: evaluation of the map against the exact surfaces of a rendered scene.
struct MapTruthSummary {
  double ghosts = NAN, astray = NAN;  ///< shares of the points: on a mover, on no surface
  double coverage = NAN;              ///< share of the visible static surface
  double oracle_coverage = NAN;       ///< the same for true masks and poses with the same keyframes
  double error_median_m = NAN, error_p95_m = NAN;

  double of_oracle() const { return coverage / oracle_coverage; }
};

/// `--map-full`: the cloud without a map.
struct FullCloudSummary {
  std::string file;
  std::size_t points = 0, bytes = 0;
  double ms_per_keyframe = NAN;
};

/// Figures of `--map`.
struct MapSummary {
  std::string file;                ///< "": the map is empty, and nothing is written
  std::string keyframes_by;        ///< rule that selects the keyframes
  std::size_t frames_offered = 0;  ///< frames with a pose and a depth image
  std::size_t points = 0, keyframes = 0, skipped = 0, dropped = 0;
  std::size_t full_points = 0;  ///< of all keyframes, one point per pixel after the cut
  std::size_t cut_points = 0;   ///< moving, or at a depth jump
  std::size_t bytes = 0;        ///< in memory, including the data for moving keyframes
  std::size_t cloud_bytes = 0;  ///< of the points in the file
  double leaf_m = 0, ms_per_keyframe = NAN;
  std::string last_note;  ///< reason why a keyframe was skipped
  std::optional<FullCloudSummary> full;
  std::optional<MapTruthSummary> truth;
};

inline Json to_json(const MapTruthSummary& t) {
  return {{"ghosts", number_or_null(t.ghosts)},
          {"astray", number_or_null(t.astray)},
          {"coverage", number_or_null(t.coverage)},
          {"oracle_coverage", number_or_null(t.oracle_coverage)},
          {"coverage_of_oracle", number_or_null(t.of_oracle())},
          {"error_median_m", number_or_null(t.error_median_m)},
          {"error_p95_m", number_or_null(t.error_p95_m)}};
}

inline Json to_json(const MapSummary& s) {
  Json json{{"file", s.file},
            {"points", s.points},
            {"keyframes", s.keyframes},
            {"keyframes_by", s.keyframes_by},
            {"frames_offered", s.frames_offered},
            {"skipped", s.skipped},
            {"dropped", s.dropped},
            {"full_points", s.full_points},
            {"cut_points", s.cut_points},
            {"bytes", s.bytes},
            {"cloud_bytes", s.cloud_bytes},
            {"leaf_m", s.leaf_m},
            {"ms_per_keyframe", number_or_null(s.ms_per_keyframe)},
            {"last_note", s.last_note}};
  if (s.full)
    json["full"] = {{"file", s.full->file},
                    {"points", s.full->points},
                    {"bytes", s.full->bytes},
                    {"ms_per_keyframe", number_or_null(s.full->ms_per_keyframe)}};
  if (s.truth) json["truth"] = to_json(*s.truth);
  return json;
}

}  // namespace dynfilter::command
