// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/compiled.hpp>
#include <dynfilter/pipeline/stage_reader.hpp>
#include <vector>

namespace dynfilter {

/// All combinators that a pipeline file may name.
/// The YAML reader, `dynfilter filters` and the docs use this table.
DYNFILTER_INLINE const std::vector<CombinatorEntry>& combinator_table();

}  // namespace dynfilter

#ifndef DYNFILTER_COMPILED
#include <dynfilter/pipeline/combinator_entries.hpp>
#endif
