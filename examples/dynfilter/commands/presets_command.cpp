// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <dynfilter/pipeline/presets.hpp>

#include <CLI/CLI.hpp>
#include <dynfilter/config/yaml.hpp>
#include <memory>
#include <string>
#include <vector>

#include "command.hpp"
#include "running/presets.hpp"
#include "text/json.hpp"
#include "text/terminal.hpp"

namespace dynfilter::command {
namespace {

struct Preset {
  std::string name, about, file;
};

/// The text `about` under the first key of the file; "" if it is missing.
std::string about(const std::string& file) {
  const YamlDocument document = YamlDocument::from_file(file);
  for (const auto& [key, value] : document.root().entries())
    if (value.is_map())
      if (const auto text = value.find("about")) return text->text();
  return "";
}

std::vector<Preset> presets_of(const PresetKind& kind) {
  std::vector<Preset> presets;
  for (const std::string& name : preset_names(kind)) {
    const std::string file = find_preset(name, kind).string();
    presets.push_back({name, about(file), file});
  }
  return presets;
}

void print_presets(const PresetKind& kind, const char* option) {
  fmt::print("{}s ({})\n", kind.what, option);
  for (const Preset& preset : presets_of(kind)) {
    fmt::print("  {}\n", preset.name);
    fmt::print("{}", wrapped(preset.about, text_columns(), 4));
  }
}

Json to_json(const PresetKind& kind) {
  Json presets = Json::array();
  for (const Preset& preset : presets_of(kind))
    presets.push_back({{"name", preset.name}, {"about", preset.about}, {"file", preset.file}});
  return presets;
}

int run(bool json) {
  if (json) {
    const Json all{{"pipelines", to_json(kPipelines)}, {"detectors", to_json(kDetectors)}};
    fmt::print("{}", json_text(all));
    return kDone;
  }
  print_presets(kPipelines, "--pipeline NAME");
  fmt::print("\n");
  print_presets(kDetectors, "--detector NAME");
  fmt::print("\n`dynfilter check NAME` prints the stages of a pipeline.\n");
  return kDone;
}

}  // namespace

void add_presets(CLI::App& app, Action& action) {
  auto json = std::make_shared<bool>(false);
  CLI::App* command = app.add_subcommand("presets", "Lists the pipelines and detectors that have a name.");
  command->add_flag("--json", *json, "print JSON");
  command->callback([json, &action] { action = [json] { return run(*json); }; });
}

}  // namespace dynfilter::command
