// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/hosts/orb_slam/params.hpp>
#include <dynfilter/core/needs.hpp>
#include <dynfilter/semantic/provider_registry.hpp>
#include <dynfilter/semantic/runner.hpp>
#include <memory>
#include <string>

namespace dynfilter {

/// What boxes and masks the settings promise, before any came. Of a detector both: which of them it makes is
/// seen later.
Input semantic_inputs(const OrbSlamParams& params);

namespace orb_slam::detail {

/// The runner of `boxes` and `masks`, or of `detector`; null without any of them.
std::unique_ptr<SemanticRunner> make_semantics(const OrbSlamParams& params, const std::string& settings_file,
                                               const ProviderRegistry& providers);

}  // namespace orb_slam::detail

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/hosts/orb_slam/detail/host_detector-inl.hpp>
#endif
