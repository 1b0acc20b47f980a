// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

namespace dynfilter::io {

/// Pairs of indices (into `a_s`, into `b_s`) with timestamps closer than `max_gap_s`.
/// Sorted by `a_s`.
/// Greedy like associate.py of the TUM tools:
/// the closest pair first, then the closest of the rest, each timestamp once.
/// Both lists are strictly ascending. Cost: n log n, however many pairs are close.
std::vector<std::pair<std::size_t, std::size_t>> associate(const std::vector<double>& a_s,
                                                           const std::vector<double>& b_s, double max_gap_s);

}  // namespace dynfilter::io
