// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <dynfilter/core/error.hpp>
#include <dynfilter/io/atomic_file.hpp>
#include <filesystem>
#include <fstream>
#include <optional>
#include <ostream>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

namespace dynfilter::synth {

/// A sensor setting, for display.
using SensorValues = std::vector<std::pair<std::string, double>>;

/// The scene of a rendered sequence, needed to reconstruct its exact surfaces (map_truth.hpp).
struct SceneName {
  std::string scene;
  std::uint64_t seed = 1;
  SensorValues sensor;  ///< written, but not read
};

/// Writes `scene.txt` of a sequence folder. Atomic. Throws IoError.
inline void write_scene_name(const std::filesystem::path& folder, const SceneName& name) {
  io::write_file_atomically(folder / "scene.txt", [&](std::ostream& out) {
    out << "# scene seed\n" << name.scene << ' ' << name.seed << '\n';
    if (!name.sensor.empty()) out << "# sensor\n";
    for (const auto& [key, value] : name.sensor) out << key << ' ' << value << '\n';
  });
}

/// Nothing if the file does not exist. Throws IoError for invalid content.
inline std::optional<SceneName> read_scene_name(const std::filesystem::path& folder) {
  const std::filesystem::path path = folder / "scene.txt";
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) return std::nullopt;
  std::ifstream in(path);
  std::string comment;
  std::getline(in, comment);
  SceneName name;
  if (!(in >> name.scene >> name.seed))
    throw IoError(path.string() + ": expected a scene's name and its seed");
  return name;
}

}  // namespace dynfilter::synth
