// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <dynfilter/config/near_miss.hpp>
#include <dynfilter/config/yaml.hpp>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace dynfilter::command {

/// Figures of a paper, to stand beside our own.
struct PublishedSystem {
  std::string name;
  std::string alignment;                ///< of the estimate with the truth: "SE(3)" or "Sim(3)"
  std::string note;                     ///< what it is, and where the figures are from; may be empty
  std::map<std::string, double> ate_m;  ///< RMSE by the sequence's name
};

struct BenchSequence {
  std::string name;    ///< short, for tables
  std::string folder;  ///< below the data folder
};

/// A list of sequences and pipelines.
struct Manifest {
  std::string name;
  std::string download;  ///< what to download, and where to put it
  std::vector<std::string> pipelines;
  std::vector<BenchSequence> sequences;
  std::vector<PublishedSystem> published;
};

namespace detail_manifest {

inline YamlNode required(const YamlNode& map, const std::string& key) {
  const std::optional<YamlNode> node = map.find(key);
  if (!node) map.fail("expected the key `" + key + "`");
  return *node;
}

inline void only_keys(const YamlNode& map, const std::vector<std::string>& known) {
  for (const auto& [key, value] : map.entries())
    if (std::find(known.begin(), known.end(), key) == known.end()) map.fail(unknown_name("key", key, known));
}

inline BenchSequence sequence(const YamlNode& node) {
  only_keys(node, {"name", "folder"});
  return {required(node, "name").text(), required(node, "folder").text()};
}

inline PublishedSystem published(const YamlNode& node, const std::vector<BenchSequence>& sequences) {
  only_keys(node, {"system", "alignment", "note", "ate_cm"});
  PublishedSystem system{required(node, "system").text(), required(node, "alignment").text(), "", {}};
  if (const auto note = node.find("note")) system.note = note->text();
  if (system.alignment != "SE(3)" && system.alignment != "Sim(3)")
    required(node, "alignment").fail("expected SE(3) or Sim(3)");
  for (const auto& [name, value] : required(node, "ate_cm").entries()) {
    const bool known = std::any_of(sequences.begin(), sequences.end(),
                                   [name = name](const BenchSequence& s) { return s.name == name; });
    if (!known) value.fail("no sequence of the manifest has this name");
    system.ate_m[name] = value.real() / 100;
  }
  return system;
}

}  // namespace detail_manifest

/// Throws ConfigError with the path in the file.
inline Manifest read_manifest(const std::filesystem::path& path) {
  const YamlDocument document = YamlDocument::from_file(path.string());
  const YamlNode root = document.root();
  detail_manifest::only_keys(root, {"download", "pipelines", "sequences", "published"});
  Manifest manifest;
  manifest.name = path.stem().string();
  manifest.download = detail_manifest::required(root, "download").text();
  manifest.pipelines = detail_manifest::required(root, "pipelines").texts();
  for (const YamlNode& node : detail_manifest::required(root, "sequences").items())
    manifest.sequences.push_back(detail_manifest::sequence(node));
  if (const auto published = root.find("published"))
    for (const YamlNode& node : published->items())
      manifest.published.push_back(detail_manifest::published(node, manifest.sequences));
  return manifest;
}

}  // namespace dynfilter::command
