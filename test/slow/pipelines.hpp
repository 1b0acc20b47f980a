// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/pipeline/pipeline.hpp>
#include <string>
#include <vector>

namespace crowds {

/// A pipeline file, or the text of a pipeline.
struct NamedPipeline {
  std::string name, source;
  bool is_file = false;
};

/// Every preset, every pipeline of the fuzzers, every built-in filter alone and every combinator.
/// One that is added is among them.
std::vector<NamedPipeline> pipelines();

dynfilter::PipelineConfig made(const NamedPipeline& pipeline);

}  // namespace crowds
