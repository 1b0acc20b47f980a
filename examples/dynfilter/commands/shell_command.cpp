// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <dynfilter/core/error.hpp>
#include <filesystem>
#include <memory>
#include <ostream>
#include <string>
#include <system_error>
#include <vector>

#include "command.hpp"
#include "completion.hpp"
#include "io/atomic_file.hpp"
#include "man_page.hpp"
#include "render/scenes.hpp"
#include "running/command_registry.hpp"
#include "running/presets.hpp"

// Completion scripts and manual pages for packages, generated from the options.
namespace dynfilter::command {
namespace {

std::string names_or_script(const CLI::App& app, const std::string& what) {
  if (what == "bash") return bash_completion(app);
  if (what == "zsh") return zsh_completion(app);
  std::vector<std::string> names;
  if (what == "pipelines") names = preset_names(kPipelines);
  if (what == "detectors") names = preset_names(kDetectors);
  if (what == "filters") names = command_registry({}).names();
  if (what == "scenes") names = render::scene_names();
  return fmt::format("{}\n", fmt::join(names, "\n"));
}

void write_page(const std::filesystem::path& folder, const std::string& name, const std::string& text) {
  io::write_file_atomically(folder / (name + ".1"), [&](std::ostream& out) { out << text; });
}

int write_pages(const CLI::App& app, const std::string& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (!std::filesystem::is_directory(folder)) throw IoError(folder + ": no folder can be made there");
  write_page(folder, "dynfilter", man_page(app));
  for (const CLI::App* command : shown_subcommands(app))
    write_page(folder, "dynfilter-" + command->get_name(), man_page_of(*command));
  return kDone;
}

}  // namespace

void add_completion(CLI::App& app, Action& action) {
  auto what = std::make_shared<std::string>();
  CLI::App* command = app.add_subcommand(
      "completion", "Prints a completion script for a shell, or a list of names, one per line.");
  command->add_option("WHAT", *what, "a shell, or a kind of names")
      ->required()
      ->check(CLI::IsMember({"bash", "zsh", "pipelines", "detectors", "filters", "scenes"}));
  command->callback([what, &app, &action] {
    action = [what, &app] {
      fmt::print("{}", names_or_script(app, *what));
      return static_cast<int>(kDone);
    };
  });
}

void add_man(CLI::App& app, Action& action) {
  auto folder = std::make_shared<std::string>();
  CLI::App* command = app.add_subcommand("man", "Writes the manual pages into a folder.");
  command->add_option("FOLDER", *folder, "is made if it does not exist")->required()->type_name("FOLDER");
  command->callback(
      [folder, &app, &action] { action = [folder, &app] { return write_pages(app, *folder); }; });
}

}  // namespace dynfilter::command
