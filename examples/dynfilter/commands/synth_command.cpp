// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <system_error>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <string>

#include "command.hpp"
#include "render/inertial_sensor.hpp"
#include "render/scene_file.hpp"
#include "render/scenes.hpp"
#include "render/sequence_renderer.hpp"
#include "render/sequence_writer.hpp"
#include "running/interruption.hpp"
#include "text/json.hpp"
#include "text/progress.hpp"

namespace dynfilter::command {
namespace {

struct SynthOptions {
  render::SequenceOptions sequence;
  std::string folder, gyro = "phone";
  bool json = false, no_right = false;
};

std::string scenes() {
  std::string text;
  for (const std::string& name : render::scene_names()) text += (text.empty() ? "" : " ") + name;
  return text;
}

// Only a synthetic sequence may be overwritten.
bool is_synthetic(const std::filesystem::path& folder) {
  std::error_code error;
  return std::filesystem::is_directory(folder / "labels", error) &&
         std::filesystem::is_regular_file(folder / "camera.yaml", error);
}

int write(SynthOptions options) {
  Interruption::watch();
  options.sequence.right_images = !options.no_right;
  options.sequence.gyro = render::gyro_grade(options.gyro);
  options.sequence.overwrite = is_synthetic(options.folder);
  render::SensorValues sensor;
  {
    Progress bar(options.sequence.scene);
    sensor = render::write_sequence(options.sequence, options.folder, [&](int done, int total) {
      bar.at(static_cast<std::size_t>(done), static_cast<std::size_t>(total));
    });
  }
  if (options.json) {
    Json settings = Json::object();
    for (const auto& [key, value] : sensor) settings[key] = value;
    const Json json{{"scene", options.sequence.scene},
                    {"folder", options.folder},
                    {"frames", options.sequence.frames},
                    {"seed", options.sequence.seed},
                    {"sensor", settings}};
    fmt::print("{}", json_text(json));
  } else {
    fmt::print("{}: {} frames, seed {}, in {}\n", options.sequence.scene, options.sequence.frames,
               options.sequence.seed, options.folder);
  }
  return kDone;
}

void add_sensor(CLI::App& command, render::SequenceOptions& sequence) {
  command.add_option("--hz", sequence.rate_hz, "frames per second (default: 30, 10 outdoors, 20 in a hall)")
      ->type_name("HZ")
      ->check(CLI::Range(10.0, 60.0));
  command.add_flag("--blur", sequence.motion_blur, "motion blur: an exposure of 12 ms");
  command
      .add_option("--exposure-ms", sequence.exposure_ms,
                  "exposure time, for motion blur; 0: none (default: 0, 12 for turn, shake)")
      ->type_name("MS")
      ->check(CLI::Range(0.0, 100.0));
  command
      .add_option("--rolling-shutter-ms", sequence.rolling_shutter_ms,
                  "readout time of all rows (default: 0, 30 for static_jerk)")
      ->type_name("MS")
      ->check(CLI::Range(0.0, 100.0));
  command
      .add_option("--depth-offset-ms", sequence.depth_offset_ms,
                  "delay of the depth image relative to the colour image")
      ->type_name("MS")
      ->check(CLI::Range(0.0, 100.0))
      ->capture_default_str();
  command
      .add_option("--calibration-error", sequence.calibration_error,
                  "error of camera.yaml; 1: focal length 0.5 %, centre 3 px, corners 1 px off")
      ->type_name("X")
      ->check(CLI::Range(0.0, 10.0))
      ->capture_default_str();
  command.add_flag("--perfect-depth", sequence.perfect_depth, "true depth without noise and holes");
  command.add_option("--image-noise", sequence.image_noise, "noise of the images, standard deviation")
      ->type_name("GREY")
      ->check(CLI::Range(0.0, 50.0))
      ->capture_default_str();
  command.add_flag("--exposure", sequence.exposure_variation, "the brightness varies smoothly");
  command.add_flag("--exposure-steps", sequence.exposure_steps, "the brightness jumps once a second");
}

}  // namespace

void add_synth(CLI::App& app, Action& action) {
  auto options = std::make_shared<SynthOptions>();
  render::SequenceOptions& sequence = options->sequence;
  CLI::App* command = app.add_subcommand(
      "synth",
      "Writes a labelled synthetic sequence in TUM's layout. The folder gets rgb/ and depth/ with their "
      "lists, groundtruth.txt and camera.yaml. The truth is in labels/, dynamic/ and motion/. masks/ and "
      "detections.txt are those of a detector with faults. With a second camera there is right/, too. imu0/ "
      "has a gyroscope in EuRoC's layout."
      "\n\nScenes: " +
          scenes());
  command->add_option("SCENE", sequence.scene, "one of the scenes above")->required()->type_name("SCENE");
  command->add_option("DIR", options->folder, "folder to write; an existing synthetic sequence is replaced")
      ->required()
      ->type_name("FOLDER");
  command->add_option("--frames", sequence.frames, "number of frames")
      ->type_name("N")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  command->add_option("--seed", sequence.seed, "number of the variant: room, people and paths")
      ->type_name("N")
      ->capture_default_str();
  add_sensor(*command, sequence);
  command->add_option("--gyro", options->gyro, "errors of the gyroscope in imu0/; none: no imu0/")
      ->type_name("GRADE")
      ->check(CLI::IsMember(render::gyro_grade_names()))
      ->capture_default_str();
  command->add_option("--gyro-offset-ms", sequence.gyro_offset_ms, "delay of the gyroscope's stamps")
      ->type_name("MS")
      ->check(CLI::Range(-100.0, 100.0))
      ->capture_default_str();
  command->add_flag("--no-right", options->no_right,
                    "no images of the right camera, which take a third of the time");
  command->add_flag("--instances", sequence.instances,
                    "also instances/ and instances.txt: perfect masks and boxes of what a detector knows, "
                    "and instances_small/ at a quarter of the size");
  command->add_option("--late", sequence.detector.late_frames, "boxes arrive N frames late")
      ->type_name("N")
      ->check(CLI::Range(0, 30))
      ->capture_default_str();
  command->add_flag("--json", options->json, "print JSON");
  command->callback([options, &action] { action = [options] { return write(*options); }; });
}

}  // namespace dynfilter::command
