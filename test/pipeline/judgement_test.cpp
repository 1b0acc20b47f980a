// SPDX-License-Identifier: MIT
#include <dynfilter/pipeline/judgement.hpp>

#include "doctest/doctest.h"

using namespace dynfilter;

namespace {

constexpr Vote kAll[] = {Vote::Static, Vote::Unknown, Vote::Dynamic};

/// Static < Unknown < Dynamic: Kleene's OR is the maximum, AND the minimum.
int rank(Vote v) {
  return v == Vote::Static ? 0 : v == Vote::Unknown ? 1 : 2;
}

}  // namespace

TEST_CASE("OR is the maximum and AND the minimum of static < unknown < dynamic, in every pair") {
  for (const Vote a : kAll)
    for (const Vote b : kAll) {
      CHECK(rank(vote_or(a, b)) == std::max(rank(a), rank(b)));
      CHECK(rank(vote_and(a, b)) == std::min(rank(a), rank(b)));
      CHECK(vote_not(vote_or(a, b)) == vote_and(vote_not(a), vote_not(b)));  // De Morgan
    }
}

TEST_CASE("NOT turns the order around and leaves unknown") {
  for (const Vote a : kAll) CHECK(rank(vote_not(a)) == 2 - rank(a));
}

TEST_CASE("strict takes unknown for dynamic") {
  for (const Vote a : kAll) CHECK(vote_strict(a) == (a == Vote::Static ? Vote::Static : Vote::Dynamic));
}

TEST_CASE("a later stage of a sequence speaks where it has an opinion, and dynamic stays") {
  for (const Vote earlier : kAll)
    for (const Vote later : kAll) {
      const Vote expected = earlier == Vote::Dynamic ? Vote::Dynamic
                            : later == Vote::Unknown ? earlier
                                                     : later;
      CHECK(vote_then(earlier, later) == expected);
    }
}
