// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/core/compiled.hpp>
#include <dynfilter/pipeline/stage_reader.hpp>
#include <vector>

namespace dynfilter {

/// Every combinator that a pipeline file may name: the reader, `dynfilter filters` and the docs come from it.
DYNFILTER_INLINE const std::vector<CombinatorEntry>& combinator_table();

}  // namespace dynfilter

#ifndef DYNFILTER_COMPILED
#include <dynfilter/pipeline/combinator_entries.hpp>
#endif
