// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "run_record.hpp"
#include "text/json.hpp"

namespace dynfilter::command::report {

/// Text in HTML, between tags or within quotes.
std::string escaped(const std::string& text);

/// The page of `run`: one file without references to others.
/// `beside`: summaries of the same frames with other pipelines.
std::string run_page(const RunRecord& run, const std::vector<Json>& beside);

/// The page of `compare`. `medians` as `compare --json` has them.
std::string compare_page(const std::vector<RunRecord>& runs, const Json& medians);

/// The summaries of `none` and `oracle` in the folders beside `out`, if they are of the same frames.
std::vector<Json> reference_summaries(const std::filesystem::path& out, const Summary& own);

}  // namespace dynfilter::command::report
