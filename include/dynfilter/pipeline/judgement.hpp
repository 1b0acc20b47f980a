// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <dynfilter/core/votes.hpp>
#include <vector>

namespace dynfilter {

/// Votes, and per feature the stages (bits) that called it dynamic.
struct Judgement {
  Votes votes;
  std::vector<std::uint64_t> reasons;

  void reset(std::size_t n) {
    votes.reset(n);
    reasons.assign(n, 0);
  }
};

/// Three-valued OR (Kleene): dynamic if one says so, static if both do, else unknown.
///
///     or       | Static   Unknown  Dynamic
///     Static   | Static   Unknown  Dynamic
///     Unknown  | Unknown  Unknown  Dynamic
///     Dynamic  | Dynamic  Dynamic  Dynamic
constexpr Vote vote_or(Vote a, Vote b) {
  if (a == Vote::Dynamic || b == Vote::Dynamic) return Vote::Dynamic;
  return a == Vote::Static && b == Vote::Static ? Vote::Static : Vote::Unknown;
}

/// Three-valued AND (Kleene): static if one says so, dynamic if both do, else unknown.
///
///     and      | Static   Unknown  Dynamic
///     Static   | Static   Static   Static
///     Unknown  | Static   Unknown  Unknown
///     Dynamic  | Static   Unknown  Dynamic
constexpr Vote vote_and(Vote a, Vote b) {
  if (a == Vote::Static || b == Vote::Static) return Vote::Static;
  return a == Vote::Dynamic && b == Vote::Dynamic ? Vote::Dynamic : Vote::Unknown;
}

/// Three-valued NOT: static and dynamic change places, unknown stays.
constexpr Vote vote_not(Vote a) {
  return a == Vote::Static ? Vote::Dynamic : a == Vote::Dynamic ? Vote::Static : Vote::Unknown;
}

/// Guilty until proven static: unknown becomes dynamic.
constexpr Vote vote_strict(Vote a) {
  return a == Vote::Static ? Vote::Static : Vote::Dynamic;
}

/// Enough of several votes, given the weight of those that say dynamic and unknown: dynamic when it is
/// reached, static when it could not be reached even if all unknown ones said dynamic, else unknown. Of two
/// equal ones, needed = 1 is vote_or(), needed = 2 vote_and(); nothing is dynamic without a vote for it.
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

/// Votes about one object, taken together: dynamic with at least `min_count` dynamic votes that are at least
/// `min_share` of those that are not unknown; static with so many votes otherwise; else unknown.
constexpr Vote vote_object(int dynamic, int fixed, int min_count, double min_share) {
  const int known = dynamic + fixed;
  if (dynamic > 0 && dynamic >= min_count && dynamic >= min_share * known - 1e-9) return Vote::Dynamic;
  return known > 0 && known >= min_count ? Vote::Static : Vote::Unknown;
}

/// What a later stage of a sequence adds to what is known: it speaks where it has an opinion, and dynamic
/// stays.
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
