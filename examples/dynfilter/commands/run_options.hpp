// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>
#include <dynfilter/core/error.hpp>
#include <dynfilter/semantic/runner.hpp>
#include <string>
#include <vector>

#include "running/sequence_run.hpp"

namespace dynfilter::command {

/// For long videos and large images.
inline void add_thinning_options(CLI::App& command, std::size_t& step, double& scale) {
  command.add_option("--step", step, "play every N-th frame")
      ->type_name("N")
      ->check(CLI::Range(1, 1'000'000))
      ->capture_default_str();
  command
      .add_option("--scale", scale,
                  "make images smaller by this before anything else, above 0 to 1; the camera is adapted")
      ->type_name("S")
      ->check(CLI::Range(0.01, 1.0))
      ->capture_default_str();
}

/// Options of all commands that play a sequence.
inline void add_play_options(CLI::App& command, RunOptions& options) {
  command
      .add_option("--camera", options.camera,
                  "camera file (keys as in ORB-SLAM settings) instead of the one found")
      ->type_name("FILE");
  command
      .add_option("--sensor", options.sensor,
                  "what the odometry sees; by default what camera.yaml names, else rgbd with depth images, "
                  "else stereo with right images, else mono")
      ->check(CLI::IsMember({"rgbd", "stereo", "mono"}))
      ->type_name("SENSOR");
  command
      .add_option("--detections", options.detections,
                  "boxes; by default detections.txt or detections_*.txt of the sequence")
      ->type_name("FILE");
  command.add_flag("--no-detections", options.no_detections, "no boxes, even if the sequence has some")
      ->excludes("--detections");
  command
      .add_option("--masks", options.masks,
                  "folder of masks, 8-bit PNGs named as the colour images; by default masks/ of the "
                  "sequence")
      ->type_name("FOLDER");
  command.add_flag("--no-masks", options.no_masks, "no masks, even if the sequence has some")
      ->excludes("--masks");
  command
      .add_option("--imu", options.imu,
                  "a gyroscope's samples, from which the camera's turn is known: EuRoC's imu0/data.csv, or a "
                  "list `timestamp wx wy wz`; auto: those of the sequence")
      ->type_name("FILE");
  command
      .add_option("--wheel-odometry", options.wheel_odometry,
                  "a trajectory of the camera that was measured without images (TUM's format): its motion "
                  "from frame to frame is a prior")
      ->type_name("FILE");
  command.add_flag("--no-weights", options.no_weights,
                   "the odometry trusts a feature that slides along an edge like any other");
  command
      .add_option(
          "--detector-mode", options.detector_mode,
          "when boxes and masks arrive: sync (at once), late:N (N frames later), rate:HZ (as from a detector "
          "that takes 1/HZ) or async (from a thread of their own, at the pace of the recording)")
      ->check([](const std::string& mode) {
        try {
          parse_runner_mode(mode);
        } catch (const Error& error) {
          return std::string(error.what());
        }
        return std::string();
      })
      ->capture_default_str()
      ->type_name("MODE");
  command
      .add_option("--detector", options.detector,
                  "a detector's YAML file or preset: boxes and masks come from it, not from files "
                  "(of type `process` it starts a program)")
      ->excludes("--detections", "--no-detections", "--masks", "--no-masks")
      ->type_name("DETECTOR");
  command
      .add_option("--network-dir", options.network_dir,
                  "folder of the files that the detector's YAML names; without it the folder of the YAML")
      ->needs("--detector")
      ->type_name("FOLDER");
  command
      .add_option("--start", options.start,
                  "leave out the first N frames (with --reverse: of the reversed sequence)")
      ->type_name("N");
  command.add_option("--frames", options.frames, "play at most N frames")->type_name("N");
  add_thinning_options(command, options.step, options.scale);
  command
      .add_option("--plugin", options.plugins,
                  "load rejectors and providers from this module as well (runs its code)")
      ->type_name("FILE");
  command.add_option("--threads", options.threads, "OpenCV's threads; verdicts do not depend on it")
      ->type_name("N")
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
}

/// Options of `run` and `compare`.
inline void add_run_options(CLI::App& command, RunOptions& options) {
  add_play_options(command, options);
  command.add_flag("--reverse", options.reverse, "play from the last frame to the first");
}

/// `run` and `map` have it, `compare` builds several maps.
inline CLI::Option* add_full_map_option(CLI::App& command, RunOptions& options) {
  return command
      .add_option("--map-full", options.map_full,
                  "write also the points of all keyframes as they are, cut but not thinned, to this PLY file")
      ->type_name("FILE");
}

/// Options of `run --map`, `compare --map` and `map`. The caller declares their dependencies.
inline std::vector<CLI::Option*> add_map_options(CLI::App& command, RunOptions& options) {
  return {
      command
          .add_option("--map-leaf-m", options.map_leaf_m, "edge of the map's voxels, metres; without it 0.02")
          ->type_name("M"),
      command
          .add_option("--map-config", options.map_config,
                      "a YAML file with the map's parameters under the key mapping: carve, key_classes, ...")
          ->type_name("FILE"),
      command
          .add_option("--keyframes", options.keyframes,
                      "which frames the map is built from: own (as the odometry chooses), pose_change, "
                      "vertex_cover, every:N")
          ->capture_default_str()
          ->type_name("RULE"),
      command.add_flag("--truth", options.truth,
                       "a sequence that synth wrote: judge the map against the scene's surfaces (ghosts, "
                       "coverage, error)")};
}

}  // namespace dynfilter::command
