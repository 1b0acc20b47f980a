// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/pipeline/pipeline.hpp>
#include <string>
#include <vector>

namespace crowds {

enum class Kind {
  Preset,  ///< a file of examples/pipelines
  Fuzzed,  ///< a file of the fuzzers
  Stage    ///< the text of a pipeline with one filter or combinator
};

struct NamedPipeline {
  std::string name, source;
  Kind kind = Kind::Stage;
};

/// Every preset, every pipeline of the fuzzers, every built-in filter alone and every combinator.
/// One that is added is among them.
std::vector<NamedPipeline> pipelines();

dynfilter::PipelineConfig made(const NamedPipeline& pipeline);

}  // namespace crowds
