// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace dynfilter::render {

/// A sensor setting, for display.
using SensorValues = std::vector<std::pair<std::string, double>>;

/// The scene of a rendered sequence, needed to reconstruct its exact surfaces (map_truth.hpp).
struct SceneName {
  std::string scene;
  std::uint64_t seed = 1;
  SensorValues sensor;  ///< written, but not read
};

/// Writes `scene.txt` of a sequence folder. Atomic. Throws IoError.
void write_scene_name(const std::filesystem::path& folder, const SceneName& name);

/// Nothing if the file does not exist. Throws IoError for invalid content.
std::optional<SceneName> read_scene_name(const std::filesystem::path& folder);

}  // namespace dynfilter::render
