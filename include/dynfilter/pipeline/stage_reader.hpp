// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <dynfilter/config/near_miss.hpp>
#include <dynfilter/config/parameters.hpp>
#include <dynfilter/config/registry.hpp>
#include <dynfilter/config/yaml.hpp>
#include <dynfilter/pipeline/combinator.hpp>
#include <functional>
#include <memory>
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

  /// Refers to both, which must outlive it.
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
  static YamlNode required(const YamlNode& node, const std::string& key) {
    const auto value = find(node.entries(), key);
    if (!value) node.fail("expected the key `" + key + "`");
    return *value;
  }

 private:
  using Entries = std::vector<std::pair<std::string, YamlNode>>;
  static std::optional<YamlNode> find(const Entries& entries, const std::string& key) {
    for (const auto& [name, value] : entries)
      if (name == key) return value;
    return std::nullopt;
  }
  StagePtr named(const std::string& name, const YamlNode& value) const;
  static StagePtr made(const std::string& name, const Registry::Entry& entry, const YamlNode& value);

  const Registry& registry_;
  const std::vector<CombinatorEntry>& combinators_;
  mutable int stages_ = 0;  ///< created until now
};

inline StagePtr StageReader::stage(const YamlNode& node) const {
  if (node.is_sequence()) return named("sequence", node);
  if (node.is_text()) return named(node.text(), YamlNode(node.path()));
  const auto entries = node.entries();
  if (entries.size() != 1) node.fail("expected one stage, `name` or `name: { parameters }`");
  return named(entries[0].first, entries[0].second);
}

inline Stages StageReader::stages(const YamlNode& node) const {
  Stages result;
  for (const YamlNode& item : node.items()) result.push_back(stage(item));
  if (result.empty()) node.fail("expected at least one stage");
  return result;
}

inline std::vector<YamlNode> StageReader::nodes(const YamlNode& node, const std::vector<std::string>& keys,
                                                const std::vector<std::string>& optional) {
  std::vector<std::string> known = keys;
  known.insert(known.end(), optional.begin(), optional.end());
  const auto entries = node.entries();
  for (const auto& [key, value] : entries)
    if (std::find(known.begin(), known.end(), key) == known.end()) node.fail(unknown_name("key", key, known));
  std::vector<YamlNode> result;
  for (std::size_t k = 0; k < known.size(); ++k)
    if (const auto value = find(entries, known[k]))
      result.push_back(*value);
    else if (k < keys.size())
      node.fail("expected the key `" + known[k] + "`");
  return result;
}

inline StagePtr StageReader::named(const std::string& name, const YamlNode& value) const {
  if (++stages_ > kMaxStages)
    value.fail("expected at most " + std::to_string(kMaxStages) + " stages, combinators counted");
  for (const CombinatorEntry& combinator : combinators_)
    if (combinator.card.name == name) return combinator.make(value, *this);
  const Registry::Entry* entry = registry_.find(name);
  if (entry == nullptr) {
    std::vector<std::string> known = registry_.names();
    for (const CombinatorEntry& combinator : combinators_) known.push_back(combinator.card.name);
    value.fail(unknown_name("filter", name, known));
  }
  return made(name, *entry, value);
}

/// Any exception of a plugin's constructor becomes a ConfigError with the filter's name and place.
inline StagePtr StageReader::made(const std::string& name, const Registry::Entry& entry,
                                  const YamlNode& value) {
  std::string fault;
  try {
    return std::make_unique<FilterStage>(entry.make(value), value.path());
  } catch (const ConfigError&) {
    throw;
  } catch (const std::exception& error) {
    fault = error.what();
  } catch (...) {
    fault = "an unknown exception";
  }
  value.fail("filter `" + name + "` cannot be made: " + fault);
}

}  // namespace dynfilter
