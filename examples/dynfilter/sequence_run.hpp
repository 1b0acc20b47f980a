// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "run_summary.hpp"

namespace dynfilter::command {

struct RunOptions {
  std::string sequence, pipeline, camera, detections, masks, out;
  std::string detector, network_dir;  ///< a provider's file or preset; "": boxes and masks from files
  std::vector<std::string> plugins;
  std::size_t start = 0, frames = 0;   ///< frames 0: all
  std::string detector_mode = "sync";  ///< "sync", "async", "late:3", "rate:2"
  bool reverse = false;
  bool no_detections = false, no_masks = false;  ///< even where the sequence has some
  int threads = 1;
  std::size_t overlay_every = 0;  ///< 0: so that there are about fifty
  std::string map;                ///< a PLY file for the dense map of what stands still; "": none
  std::string map_config;         ///< a YAML file with its parameters; "": the defaults
  std::string map_full;           ///< a PLY file for the keyframes' points as they are, not thinned; "": none
  std::optional<double> map_leaf_m;
  std::string keyframes = "own";  ///< which frames the map is built from: "pose_change", "every:5", ...
  bool truth = false;             ///< judge the map against the scene of a rendered sequence
  std::string trajectory;         ///< a file with the poses; "": the odometry's own
  double max_gap_s = 0.12;        ///< poses of the file that are further apart have none between them
};

/// One sequence with one pipeline through the odometry; with options.out also the files. Throws Error for
/// input that cannot be used; then nothing is left behind.
Summary run_sequence(const RunOptions& options,
                     const std::function<void(std::size_t, std::size_t)>& progress);

}  // namespace dynfilter::command
