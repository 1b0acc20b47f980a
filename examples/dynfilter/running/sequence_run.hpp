// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "report/run_record.hpp"
#include "run_summary.hpp"

namespace dynfilter::command {

struct RunOptions {
  std::string sequence, pipeline = "dynfilter", camera, detections, masks, out;
  std::string sequence_name;  ///< in the results; "": the folder's
  std::string sensor;         ///< "rgbd", "stereo" or "mono"; "": what the sequence has, in this order
  /// File or preset of a provider; "": boxes and masks from files.
  std::string detector, network_dir;
  std::vector<std::string> plugins;
  std::size_t start = 0, frames = 0;   ///< frames 0: all
  std::size_t step = 1;                ///< every how many-th frame is played
  double scale = 1;                    ///< images are made smaller by this
  bool live = false;                   ///< show the frames in a window
  std::string video;                   ///< file for the annotated video; "": none
  std::string detector_mode = "sync";  ///< "sync", "async", "late:3", "rate:2"
  bool reverse = false;
  bool no_detections = false, no_masks = false;  ///< true: ignored even if the sequence has some
  bool no_weights = false;                       ///< features that slide along an edge count like others
  int threads = 1;
  std::size_t overlay_every = 0;  ///< 0: about fifty pictures in all
  bool force = false;             ///< replace the results in `out`
  std::string map;                ///< PLY file for the dense map of the static scene; "": none
  std::string map_config;         ///< YAML file with parameters of the map; "": the defaults
  std::string map_full;           ///< PLY file for all points of the keyframes, not thinned; "": none
  std::optional<double> map_leaf_m;
  /// Frames that the map is built from: "pose_change", "every:5", ...
  std::string keyframes = "own";
  bool truth = false;       ///< evaluate the map against the scene of a rendered sequence
  std::string trajectory;   ///< file with the poses; "": the odometry's own
  double max_gap_s = 0.12;  ///< poses are not interpolated across longer gaps
  /// A gyroscope's samples, "auto": the sequence's own; a trajectory that was measured without the images.
  std::string imu, wheel_odometry;
};

/// A record of a run for a report of several.
struct RecordOptions {
  std::size_t pictures = 0, picture_bytes = 0, map_points = 0, rows = 0;  ///< at most, of this run
  report::RunRecord* record = nullptr;                                    ///< is filled; null: none is made
};

/// Runs one pipeline on one sequence with the odometry. Writes files if options.out is set.
/// Throws Error for unusable input, and then leaves no files.
Summary run_sequence(const RunOptions& options, const std::function<void(std::size_t, std::size_t)>& progress,
                     const RecordOptions& record = {});

}  // namespace dynfilter::command
