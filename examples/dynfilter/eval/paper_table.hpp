// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "eval/comparison.hpp"
#include "eval/provenance.hpp"

// A comparison as a table for a paper. All three have the same columns, and notes that explain them.
namespace dynfilter::eval {

/// For \input in a document with \usepackage{booktabs}.
std::string latex_table(const Comparison& comparison, const Provenance& provenance);
std::string markdown_table(const Comparison& comparison, const Provenance& provenance);
/// All digits, a line per row, the provenance in columns of its own. Empty: not known.
std::string csv_table(const Comparison& comparison, const Provenance& provenance);

/// "latex", "markdown" or "csv". Throws Error for another one.
std::string paper_table(const std::string& format, const Comparison& comparison,
                        const Provenance& provenance);

}  // namespace dynfilter::eval
