// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <dynfilter/config/parameters.hpp>
#include <dynfilter/config/registry.hpp>
#include <dynfilter/core/error.hpp>
#include <dynfilter/core/needs.hpp>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <dynfilter/config/near_miss.hpp>
#include <dynfilter/pipeline/combinator_table.hpp>
#include <dynfilter/pipeline/pipeline_yaml.hpp>
#include <dynfilter/pipeline/stage_reader.hpp>
#include <memory>
#include <string>
#include <vector>

#include "command.hpp"
#include "running/command_registry.hpp"
#include "text/json.hpp"
#include "text/terminal.hpp"

namespace dynfilter::command {
namespace {

struct FiltersOptions {
  std::string name;
  std::vector<std::string> plugins;
  bool json = false;
};

Json parameters_json(const std::vector<FieldInfo>& fields) {
  Json parameters = Json::array();
  for (const FieldInfo& field : fields) {
    parameters.push_back({{"name", field.name},
                          {"type", field.type},
                          {"unit", field.unit},
                          {"default", field.default_value},
                          {"range", field.range},
                          {"doc", field.doc}});
  }
  return parameters;
}

Json card_json(const FilterCard& card) {
  return {{"name", card.name},
          {"summary", card.summary},
          {"required", needs_text(card.name, card.needs.required)},
          {"optional", to_string(card.needs.optional)},
          {"history_frames", card.needs.history_frames},
          {"parameters", parameters_json(card.parameters)}};
}

Json combinator_json(const CombinatorCard& card) {
  return {{"name", card.name},
          {"form", card.form},
          {"summary", card.summary},
          {"dynamic", card.dynamic},
          {"parameters", parameters_json(card.parameters)}};
}

void print_parameters(const std::vector<FieldInfo>& fields) {
  std::size_t name_width = 0;
  for (const FieldInfo& field : fields) name_width = std::max(name_width, field.name.size());
  fmt::print("\nparameters (default, range)\n");
  for (const FieldInfo& field : fields) {
    fmt::print("  {:{}}  {}{}{}\n", field.name, name_width, field.default_value,
               field.unit.empty() ? "" : " " + field.unit,
               field.range.empty() ? "" : "   [" + field.range + "]");
    fmt::print("{}", wrapped(field.doc, text_columns(), name_width + 6));
  }
}

void print_card(const FilterCard& card) {
  fmt::print("{}\n", wrapped(card.name + ": " + card.summary, text_columns()));
  fmt::print("  needs       {}\n", needs_text(card.name, card.needs.required));
  if (card.needs.optional != Input::None)
    fmt::print("  uses        {}, where given\n", to_string(card.needs.optional));
  if (card.needs.history_frames > 0)
    fmt::print("  keeps       {} earlier frame{} (by default)\n", card.needs.history_frames,
               card.needs.history_frames == 1 ? "" : "s");
  if (card.parameters.empty()) fmt::print("\nno parameters\n");
  if (!card.parameters.empty()) print_parameters(card.parameters);
}

void print_combinator(const CombinatorCard& card) {
  fmt::print("{}\n", wrapped(card.name + ": " + card.summary, text_columns()));
  fmt::print("{}{}", wrapped(card.name + ": " + card.form, text_columns(), 2),
             wrapped("a feature is dynamic " + card.dynamic, text_columns(), 2));
  if (!card.parameters.empty()) print_parameters(card.parameters);
}

void print_entry(const std::string& name, const std::string& summary, const std::string& more) {
  constexpr std::size_t kTextAt = 27;
  const std::string text = wrapped(summary, text_columns(), kTextAt), left = "  " + name;
  fmt::print("{}{}", left + (left.size() < kTextAt ? text.substr(left.size()) : "\n" + text),
             wrapped(more, text_columns(), kTextAt + 2));
}

void print_list(const Registry& registry) {
  fmt::print("rejectors\n");
  for (const std::string& name : registry.names()) {
    const FilterCard& card = registry.find(name)->card;
    print_entry(name, card.summary, "needs " + needs_text(card.name, card.needs.required));
  }
  fmt::print("\ncombinators\n");
  for (const CombinatorEntry& entry : combinator_table())
    print_entry(entry.card.name, entry.card.summary, entry.card.name + ": " + entry.card.form);
  fmt::print("\n`dynfilter filters NAME` prints a card with all parameters.\n");
}

void print_list_json(const Registry& registry) {
  Json json{{"filters", Json::array()}, {"combinators", Json::array()}};
  for (const std::string& name : registry.names())
    json["filters"].push_back(card_json(registry.find(name)->card));
  for (const CombinatorEntry& entry : combinator_table())
    json["combinators"].push_back(combinator_json(entry.card));
  fmt::print("{}", json_text(json));
}

int print_one(const Registry& registry, const FiltersOptions& options) {
  if (const Registry::Entry* entry = registry.find(options.name)) {
    options.json ? fmt::print("{}", json_text(card_json(entry->card))) : print_card(entry->card);
    return kDone;
  }
  std::vector<std::string> known = registry.names();
  for (const CombinatorEntry& entry : combinator_table()) {
    const CombinatorCard& card = entry.card;
    if (card.name == options.name) {
      options.json ? fmt::print("{}", json_text(combinator_json(card))) : print_combinator(card);
      return kDone;
    }
    known.push_back(card.name);
  }
  throw ConfigError("", unknown_name("filter", options.name, known));
}

}  // namespace

void add_filters(CLI::App& app, Action& action) {
  auto options = std::make_shared<FiltersOptions>();
  CLI::App* command = app.add_subcommand("filters",
                                         "Lists rejectors and combinators, or prints the card of one. A card "
                                         "has needs, parameters, defaults, units "
                                         "and ranges.");
  command->add_option("NAME", options->name, "a rejector or a combinator")->type_name("FILTER");
  command->add_option("--plugin", options->plugins, "load rejectors from this module as well (runs its code)")
      ->type_name("FILE");
  command->add_flag("--json", options->json, "print JSON");
  command->callback([options, &action] {
    action = [options] {
      const Registry registry = command_registry(options->plugins);
      if (!options->name.empty()) return print_one(registry, *options);
      options->json ? print_list_json(registry) : print_list(registry);
      return static_cast<int>(kDone);
    };
  });
}

}  // namespace dynfilter::command
