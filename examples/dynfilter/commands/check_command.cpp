// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <dynfilter/core/needs.hpp>
#include <dynfilter/core/verdict.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/geometry/rigid_motion.hpp>
#include <dynfilter/geometry/two_view_model.hpp>
#include <dynfilter/pipeline/pipeline.hpp>
#include <dynfilter/pipeline/stage.hpp>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "command.hpp"
#include "running/command_registry.hpp"
#include "running/oracle_filter.hpp"
#include "running/presets.hpp"
#include "text/json.hpp"
#include "text/terminal.hpp"

namespace dynfilter::command {
namespace {

struct CheckOptions {
  std::string pipeline;
  std::vector<std::string> plugins;
  bool json = false;
};

constexpr CallPoint kCallPoints[] = {CallPoint::BeforePose, CallPoint::AfterPose, CallPoint::AtKeyframe};

bool is_filter(const Stage& stage) {
  return dynamic_cast<const FilterStage*>(&stage) != nullptr;
}

// Required and optional inputs over all stages.
Needs needs_of(const Pipeline& pipeline) {
  Needs all;
  for (const CallPoint point : kCallPoints) {
    if (!pipeline.stages(point)) continue;
    pipeline.stages(point)->for_each([&](const Stage& stage, int) {
      if (!is_filter(stage)) return;
      all.required = all.required | stage.needs().required;
      all.optional = all.optional | stage.needs().optional;
      all.history_frames = std::max(all.history_frames, stage.needs().history_frames);
    });
  }
  all.optional = without(all.optional, all.required);
  return all;
}

std::string required_by(const Pipeline& pipeline, const Needs& needs) {
  return needs_text(uses_stage(pipeline, OracleFilter::kName) ? OracleFilter::kName : "", needs.required);
}

void print_stages(const Stage& root) {
  root.for_each([](const Stage& stage, int depth) {
    const std::string name = std::string(static_cast<std::size_t>(4 + 2 * depth), ' ') + stage.name();
    if (!is_filter(stage)) {
      fmt::print("{}\n", name);
    } else {
      const Needs needs = stage.needs();
      const bool more = needs.optional != Input::None;
      constexpr std::size_t kTextAt = 40;
      const std::string text = wrapped("needs " + needs_text(stage.name(), needs.required) +
                                           (more ? "; uses " + to_string(needs.optional) : ""),
                                       text_columns(), kTextAt);
      fmt::print("{}", name + (name.size() < kTextAt ? text.substr(name.size()) : "\n" + text));
    }
  });
}

void print_text(const Pipeline& pipeline, const std::string& file) {
  fmt::print("{}: well formed ({})\n", pipeline.name(), file);
  for (const CallPoint point : kCallPoints) {
    if (!pipeline.stages(point)) continue;
    fmt::print("  {}\n", to_string(point));
    print_stages(*pipeline.stages(point));
  }
  const Needs needs = needs_of(pipeline);
  fmt::print("{}", wrapped(fmt::format("inputs: {}; used where given: {}; earlier frames kept: {}",
                                       required_by(pipeline, needs), to_string(needs.optional),
                                       needs.history_frames),
                           text_columns(), 2));
  fmt::print("  a stage whose input is missing is skipped, and the report says so\n");
}

void print_json(const Pipeline& pipeline, const std::string& file) {
  Json stages = Json::array();
  for (const CallPoint point : kCallPoints) {
    if (!pipeline.stages(point)) continue;
    pipeline.stages(point)->for_each([&](const Stage& stage, int depth) {
      stages.push_back({{"call_point", to_string(point)},
                        {"depth", depth},
                        {"name", stage.name()},
                        {"path", stage.path()},
                        {"filter", is_filter(stage)},
                        {"required", needs_text(stage.name(), stage.needs().required)},
                        {"optional", to_string(stage.needs().optional)}});
    });
  }
  const Needs needs = needs_of(pipeline);
  const Json json{{"pipeline", pipeline.name()},
                  {"file", file},
                  {"required", required_by(pipeline, needs)},
                  {"optional", to_string(needs.optional)},
                  {"history_frames", needs.history_frames},
                  {"stages", stages}};
  fmt::print("{}", json_text(json));
}

}  // namespace

void add_check(CLI::App& app, Action& action) {
  auto options = std::make_shared<CheckOptions>();
  CLI::App* command = app.add_subcommand(
      "check", "Prints the mistake in a pipeline, or its stages and the inputs that they need.");
  command->add_option("PIPELINE", options->pipeline, "a YAML file, or a preset's name (`dynfilter presets`)")
      ->required()
      ->type_name("PIPELINE");
  command->add_option("--plugin", options->plugins, "load rejectors from this module as well (runs its code)")
      ->type_name("FILE");
  command->add_flag("--json", options->json, "print JSON");
  command->callback([options, &action] {
    action = [options] {
      const std::string file = find_pipeline(options->pipeline).string();
      const Pipeline pipeline(named_pipeline(options->pipeline, command_registry(options->plugins)));
      options->json ? print_json(pipeline, file) : print_text(pipeline, file);
      return static_cast<int>(kDone);
    };
  });
}

}  // namespace dynfilter::command
