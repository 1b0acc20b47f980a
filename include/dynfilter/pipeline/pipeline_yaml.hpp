// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/config/registry.hpp>
#include <dynfilter/config/yaml.hpp>
#include <dynfilter/pipeline/pipeline.hpp>
#include <string>

namespace dynfilter {

/// Reads the map under `pipeline:`. Throws ConfigError naming the path and what was expected.
PipelineConfig read_pipeline(const YamlNode& node, const Registry& registry);
/// Reads a pipeline from a document with a `pipeline:` map.
/// Other content is ignored, so the document may be an ORB-SLAM settings file. Throws ConfigError.
PipelineConfig read_pipeline(const YamlDocument& document, const Registry& registry);
/// Reads a pipeline file. Throws ConfigError with the file name.
PipelineConfig pipeline_from_file(const std::string& path, const Registry& registry);
/// Reads a pipeline from YAML text. Throws ConfigError.
PipelineConfig pipeline_from_text(const std::string& text, const Registry& registry);

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/pipeline/detail/pipeline_yaml-inl.hpp>
#endif
