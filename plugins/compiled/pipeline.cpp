// SPDX-License-Identifier: MIT
#include <dynfilter/pipeline/combinator_entries.hpp>
