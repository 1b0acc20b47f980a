// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <dynfilter/core/votes.hpp>
#include <vector>

namespace dynfilter {

/// Votes, and for each feature the stages that voted dynamic, as bits.
struct Judgement {
  Votes votes;
  std::vector<std::uint64_t> reasons;

  /// N features, all Unknown.
  void reset(std::size_t n) {
    votes.reset(n);
    reasons.assign(n, 0);
  }
};

/// Three-valued OR (Kleene): dynamic if one vote is, static if both are, else unknown.
///
///     or       | Static   Unknown  Dynamic
///     Static   | Static   Unknown  Dynamic
///     Unknown  | Unknown  Unknown  Dynamic
///     Dynamic  | Dynamic  Dynamic  Dynamic
constexpr Vote vote_or(Vote a, Vote b) {
  if (a == Vote::Dynamic || b == Vote::Dynamic) return Vote::Dynamic;
  return a == Vote::Static && b == Vote::Static ? Vote::Static : Vote::Unknown;
}

/// Three-valued AND (Kleene): static if one vote is, dynamic if both are, else unknown.
///
///     and      | Static   Unknown  Dynamic
///     Static   | Static   Static   Static
///     Unknown  | Static   Unknown  Unknown
///     Dynamic  | Static   Unknown  Dynamic
constexpr Vote vote_and(Vote a, Vote b) {
  if (a == Vote::Static || b == Vote::Static) return Vote::Static;
  return a == Vote::Dynamic && b == Vote::Dynamic ? Vote::Dynamic : Vote::Unknown;
}

/// Three-valued NOT: exchanges static and dynamic and keeps unknown.
constexpr Vote vote_not(Vote a) {
  return a == Vote::Static ? Vote::Dynamic : a == Vote::Dynamic ? Vote::Static : Vote::Unknown;
}

/// Turns unknown into dynamic.
constexpr Vote vote_strict(Vote a) {
  return a == Vote::Static ? Vote::Static : Vote::Dynamic;
}

/// Threshold on the weight of several votes, from the weights of dynamic and unknown ones. Dynamic if the
/// dynamic weight reaches `needed`. Static if it would not reach `needed` even with all unknown weight. Else
/// unknown. For two equal weights, needed = 1 is vote_or() and needed = 2 is vote_and(). Without a dynamic
/// vote the result is never dynamic.
///
///     2 of 3   | dynamic votes: 0   1         2        3
///     unknown 0| Static     Static    Dynamic  Dynamic
///     unknown 1| Static     Unknown   Dynamic  -
///     unknown 2| Unknown    Unknown   -        -
///     unknown 3| Unknown    -         -        -
constexpr Vote vote_count(double dynamic, double unknown, double needed) {
  constexpr double kRounding = 1e-9;
  if (dynamic > 0 && dynamic >= needed - kRounding) return Vote::Dynamic;
  const double possible = dynamic + unknown;
  return possible > 0 && possible >= needed - kRounding ? Vote::Unknown : Vote::Static;
}

/// Combines the votes on one object. Dynamic with at least `min_count` dynamic votes, which are at least
/// `min_share` of the known votes. Otherwise static with at least `min_count` known votes, else unknown.
constexpr Vote vote_object(int dynamic, int fixed, int min_count, double min_share) {
  const int known = dynamic + fixed;
  if (dynamic > 0 && dynamic >= min_count && dynamic >= min_share * known - 1e-9) return Vote::Dynamic;
  return known > 0 && known >= min_count ? Vote::Static : Vote::Unknown;
}

/// Merges the vote of a later stage of a sequence into the earlier one.
/// A known vote replaces the earlier one, except that dynamic is final.
///
///     then     | Static   Unknown  Dynamic   (later)
///     Static   | Static   Static   Dynamic
///     Unknown  | Static   Unknown  Dynamic
///     Dynamic  | Dynamic  Dynamic  Dynamic
constexpr Vote vote_then(Vote earlier, Vote later) {
  if (earlier == Vote::Dynamic || later == Vote::Unknown) return earlier;
  return later;
}

}  // namespace dynfilter
