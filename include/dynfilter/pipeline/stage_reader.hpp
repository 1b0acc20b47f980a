// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/config/parameters.hpp>
#include <dynfilter/config/registry.hpp>
#include <dynfilter/config/yaml.hpp>
#include <dynfilter/pipeline/combinator.hpp>
#include <dynfilter/pipeline/pipeline.hpp>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace dynfilter {

class StageReader;

/// Description of a combinator for `dynfilter filters` and the docs.
struct CombinatorCard {
  std::string name;
  std::string form;     ///< notation after `name: `
  std::string summary;  ///< one line
  std::string dynamic;  ///< "a feature is dynamic ..."
  std::vector<FieldInfo> parameters;
};

/// A combinator that a pipeline file may name.
struct CombinatorEntry {
  CombinatorCard card;
  std::function<StagePtr(const YamlNode& value, const StageReader& reader)> make;
};

/// Builds the tree of stages that a YAML node describes. Every error names its path.
class StageReader {
 public:
  /// Largest number of stages at one call point. A verdict's reasons have one bit for each.
  static constexpr int kMaxStages = 64;

  StageReader(const Registry& registry, const std::vector<CombinatorEntry>& combinators)
      : registry_(registry), combinators_(combinators) {}

  /// `name`, `name: parameters`, or a list (a sequence).
  StagePtr stage(const YamlNode& node) const;
  /// A list with at least one stage.
  Stages stages(const YamlNode& node) const;
  /// The nodes under fixed keys, in the order of `keys`, then of `optional`.
  static std::vector<YamlNode> nodes(const YamlNode& node, const std::vector<std::string>& keys,
                                     const std::vector<std::string>& optional = {});
  /// The value of a required key. Other keys are allowed.
  static YamlNode required(const YamlNode& node, const std::string& key);

 private:
  using Entries = std::vector<std::pair<std::string, YamlNode>>;
  static std::optional<YamlNode> find(const Entries& entries, const std::string& key);

  StagePtr named(const std::string& name, const YamlNode& value) const;
  static StagePtr made(const std::string& name, const Registry::Entry& entry, const YamlNode& value);

  const Registry& registry_;
  const std::vector<CombinatorEntry>& combinators_;
  mutable int stages_ = 0;  ///< created until now
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/pipeline/detail/stage_reader-inl.hpp>
#endif
