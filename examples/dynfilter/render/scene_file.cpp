// SPDX-License-Identifier: MIT
#include "render/scene_file.hpp"

#include <dynfilter/core/error.hpp>
#include <fstream>
#include <ostream>
#include <system_error>

#include "io/atomic_file.hpp"

namespace dynfilter::render {

void write_scene_name(const std::filesystem::path& folder, const SceneName& name) {
  io::write_file_atomically(folder / "scene.txt", [&](std::ostream& out) {
    out << "# scene seed\n" << name.scene << ' ' << name.seed << '\n';
    if (!name.sensor.empty()) out << "# sensor\n";
    for (const auto& [key, value] : name.sensor) out << key << ' ' << value << '\n';
  });
}

std::optional<SceneName> read_scene_name(const std::filesystem::path& folder) {
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

}  // namespace dynfilter::render
