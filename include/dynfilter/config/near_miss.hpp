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

/// The name closest to `word`, if at most a third of its letters differ.
/// Else the first name that begins with `word`, as `max_distance_px` with `max_dist`. Else "".
std::string near_miss(const std::string& word, const std::vector<std::string>& names);

/// Suffix for an error message: " (did you mean `limit`?)" or "".
std::string did_you_mean(const std::string& word, const std::vector<std::string>& names);

// The texts of all errors about a name that is not known.

/// "unknown key `x` (did you mean `y`?); known keys: y, z". `what` is singular: "key", "filter".
std::string unknown_name(const std::string& what, const std::string& word,
                         const std::vector<std::string>& known);

/// "expected one of y, z, got `x` (did you mean `y`?)".
std::string expected_one_of(const std::vector<std::string>& known, const std::string& word);

/// The words with ", " between them.
std::string joined(const std::vector<std::string>& words);

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/config/detail/near_miss-inl.hpp>
#endif
