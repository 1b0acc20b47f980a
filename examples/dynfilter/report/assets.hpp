// SPDX-License-Identifier: MIT
#pragma once

#include <string_view>

/// The parts of the page, which the build embeds (embed.cmake).
namespace dynfilter::command::report::assets {

std::string_view page();
std::string_view style();
std::string_view script();
/// "sha256-...", for the content security policy.
extern const std::string_view kStyleHash, kScriptHash;
/// Whether uPlot is part of the script.
extern const bool kHasPlots;

}  // namespace dynfilter::command::report::assets
