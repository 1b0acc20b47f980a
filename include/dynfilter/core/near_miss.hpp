// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace dynfilter {

std::string lower_case(std::string text);

/// Number of letters to change, add, remove or swap with a neighbour to turn `a` into `b`.
/// This is the optimal string alignment distance. Case is ignored.
std::size_t edit_distance(const std::string& a, const std::string& b);

/// The name closest to `word`, if at most a third of its letters differ. Else "".
std::string near_miss(const std::string& word, const std::vector<std::string>& names);

/// Suffix for an error message: " (did you mean `limit`?)" or "".
std::string did_you_mean(const std::string& word, const std::vector<std::string>& names);

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/core/detail/near_miss-inl.hpp>
#endif
