// SPDX-License-Identifier: MIT
#include "pipelines.hpp"

#include <algorithm>
#include <dynfilter/config/registry.hpp>
#include <dynfilter/core/filter.hpp>
#include <dynfilter/core/needs.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/evidence/evidence.hpp>
#include <dynfilter/pipeline/builtin_filters.hpp>
#include <dynfilter/pipeline/combinator_table.hpp>
#include <dynfilter/pipeline/pipeline_yaml.hpp>
#include <filesystem>
#include <memory>
#include <sstream>

namespace crowds {

using namespace dynfilter;

namespace {

constexpr const char* kEverySecond = "every_second";

/// Votes every second feature dynamic, so that what extends or combines votes has something to do.
class EverySecond final : public Filter {
 public:
  std::string name() const override { return kEverySecond; }
  Needs needs() const override { return {}; }
  void apply(const Evidence& evidence, Votes& votes) override {
    for (std::size_t i = 0; i < evidence.size(); i += 2)
      if (evidence.judged(i)) votes.cast(i, Vote::Dynamic);
  }
};

Registry registry() {
  Registry r = builtin_filters();
  for (const char* name : {kEverySecond, "oracle"})
    r.add({{name, "", {}, {}}, [](const YamlNode&) { return std::make_unique<EverySecond>(); }});
  return r;
}

std::string replaced(std::string text, const std::string& what, const std::string& by) {
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + by.size()))
    text.replace(at, what.size(), by);
  return text;
}

void add_files(const char* folder, Kind kind, std::vector<NamedPipeline>& all) {
  std::vector<NamedPipeline> found;
  for (const auto& entry : std::filesystem::directory_iterator(std::string(DYNFILTER_SOURCE_DIR) + folder))
    if (entry.path().extension() == ".yaml")
      found.push_back({entry.path().stem().string(), entry.path().string(), kind});
  std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.name < b.name; });
  all.insert(all.end(), found.begin(), found.end());
}

NamedPipeline of_stages(const std::string& name, const std::string& stages) {
  return {name, "%YAML:1.0\n---\npipeline:\n  name: crowd\n  before_pose:\n" + stages, Kind::Stage};
}

/// What a choice or a flag may be besides its default.
std::vector<std::string> other_values(const FieldInfo& field) {
  if (field.type == "flag") return {field.default_value == "true" ? "false" : "true"};
  if (field.type != "choice") return {};
  std::vector<std::string> others;
  std::istringstream words(replaced(field.range, ",", " "));
  for (std::string word; words >> word;)
    if (word != field.default_value) others.push_back(word);
  return others;
}

/// The stage with its defaults, and once for every other value of a choice or a flag.
void add_variants(const std::string& name, const std::vector<FieldInfo>& parameters, const std::string& first,
                  const std::string& fixed, std::vector<NamedPipeline>& all) {
  const auto with = [&](const std::string& parameter) {
    const std::string both = fixed + (fixed.empty() || parameter.empty() ? "" : ", ") + parameter;
    all.push_back(of_stages(name + (parameter.empty() ? "" : " { " + parameter + " }"),
                            first + "    - " + name + (both.empty() ? "" : ": { " + both + " }") + "\n"));
  };
  with("");
  for (const FieldInfo& field : parameters)
    for (const std::string& value : other_values(field)) with(field.name + ": " + value);
}

}  // namespace

std::vector<NamedPipeline> pipelines() {
  std::vector<NamedPipeline> all;
  add_files("/examples/pipelines", Kind::Preset, all);
  add_files("/test/fuzz/pipelines", Kind::Fuzzed, all);
  const Registry known = builtin_filters();
  for (const std::string& name : known.names())
    add_variants(name, known.find(name)->card.parameters, "    - " + std::string(kEverySecond) + "\n", "",
                 all);
  for (const CombinatorEntry& entry : combinator_table()) {
    const std::string form =
        replaced(replaced(entry.card.form, "[stage, ...]", "[stage]"), ", parameter: ...", "");
    if (entry.card.parameters.empty())
      all.push_back(of_stages(
          entry.card.name, "    - " + entry.card.name + ": " + replaced(form, "stage", kEverySecond) + "\n"));
    else
      add_variants(entry.card.name, entry.card.parameters, "",
                   replaced(replaced(replaced(form, "{ ", ""), " }", ""), "stage", kEverySecond), all);
  }
  return all;
}

PipelineConfig made(const NamedPipeline& pipeline) {
  return pipeline.kind != Kind::Stage ? pipeline_from_file(pipeline.source, registry())
                                      : pipeline_from_text(pipeline.source, registry());
}

}  // namespace crowds
