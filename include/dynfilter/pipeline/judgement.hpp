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
