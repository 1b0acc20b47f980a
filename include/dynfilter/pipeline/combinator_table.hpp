// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/pipeline/stage_reader.hpp>
#include <vector>

namespace dynfilter {

/// All combinators that a pipeline file may name.
/// The YAML reader, `dynfilter filters` and the docs use this table.
const std::vector<CombinatorEntry>& combinator_table();

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/pipeline/detail/combinator_table-inl.hpp>
#endif
