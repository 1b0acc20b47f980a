// SPDX-License-Identifier: MIT
#include <cmath>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/pipeline/judgement.hpp>
#include <string>
#include <vector>

#include "doctest/doctest.h"

namespace judgement_test {

using namespace dynfilter;

namespace {

constexpr Vote kAll[] = {Vote::Static, Vote::Unknown, Vote::Dynamic};

/// Static < Unknown < Dynamic: Kleene's OR is the maximum, AND the minimum.
int rank(Vote v) {
  return v == Vote::Static ? 0 : v == Vote::Unknown ? 1 : 2;
}

}  // namespace

TEST_CASE("votes begin unknown, with a suspicion in the middle, and no suspicion leaves [0, 1]") {
  Votes votes;
  votes.reset(7);
  CHECK(votes.count(Vote::Unknown) == 7);
  CHECK(votes.suspicion(0) == 0.5F);
  votes.cast(0, Vote::Dynamic);
  votes.cast(1, Vote::Static);
  votes.cast(2, Vote::Unknown);
  votes.cast(3, Vote::Dynamic, 7.0F);
  votes.cast(4, Vote::Static, -7.0F);
  votes.cast(5, Vote::Static, std::nanf(""));
  votes.cast(6, Vote::Unknown, 0.25F);
  const float expected[] = {1, 0, 0.5F, 1, 0, 0.5F, 0.25F};
  for (std::size_t i = 0; i < 7; ++i) CHECK(votes.suspicion(i) == expected[i]);
  CHECK(votes.count(Vote::Dynamic) == 2);
  CHECK(votes[3] == Vote::Dynamic);
}

TEST_CASE("votes have the names of the documentation") {
  CHECK(std::string(to_string(Vote::Static)) == "static");
  CHECK(std::string(to_string(Vote::Unknown)) == "unknown");
  CHECK(std::string(to_string(Vote::Dynamic)) == "dynamic");
}

TEST_CASE("priors of two stages are joined, and what is not kept becomes unknown but stays suspicious") {
  Votes a, b;
  a.reset(3), b.reset(3);
  a.mark_prior(1), b.mark_prior(0);
  a.add_priors(b);
  CHECK(a.prior(0));
  CHECK(a.prior(1));
  CHECK_FALSE(a.prior(2));
  CHECK(a.count_prior() == 2);
  CHECK_FALSE(b.prior(1));
  a.cast(1, Vote::Dynamic, 0.75F), a.cast(2, Vote::Static);
  const std::vector<std::uint8_t> kept{1, 0, 1};
  a.keep_only(kept);
  CHECK(a[1] == Vote::Unknown);
  CHECK(a.suspicion(1) == 0.75F);
  CHECK(a[2] == Vote::Static);
}

TEST_CASE("the suspicion of a distance: none at 0, half at the limit, more beyond") {
  CHECK(suspicion(0, 2) == 0.0F);
  CHECK(suspicion(2, 2) == 0.5F);
  CHECK(suspicion(6, 2) == 0.75F);
  CHECK(suspicion(0, 0) == 0.0F);
  CHECK(suspicion(1, 0) == 1.0F);
  CHECK(suspicion(-1, 2) == 0.5F);
  CHECK(suspicion(1, -2) == 0.5F);
  CHECK(suspicion(std::nan(""), 2) == 0.5F);
}

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

// The meaning of three values: the result if each unknown vote were static or dynamic.
TEST_CASE("k of n is dynamic when it is whatever the unknown ones are, static when it never is") {
  for (int n = 1; n <= 4; ++n)
    for (int k = 1; k <= n; ++k)
      for (int code = 0; code < 81; ++code) {
        int dynamic = 0, unknown = 0;
        for (int m = 0, rest = code; m < n; ++m, rest /= 3) {
          dynamic += rest % 3 == 2 ? 1 : 0;
          unknown += rest % 3 == 1 ? 1 : 0;
        }
        bool always = true, ever = false;
        for (int also = 0; also <= unknown; ++also) {
          always = always && dynamic + also >= k;
          ever = ever || dynamic + also >= k;
        }
        const Vote expected = always ? Vote::Dynamic : ever ? Vote::Unknown : Vote::Static;
        CHECK(vote_count(dynamic, unknown, k) == expected);
      }
}

TEST_CASE("1 of 2 is OR and 2 of 2 is AND for every pair") {
  for (const Vote a : kAll)
    for (const Vote b : kAll) {
      const int dynamic = (a == Vote::Dynamic ? 1 : 0) + (b == Vote::Dynamic ? 1 : 0);
      const int unknown = (a == Vote::Unknown ? 1 : 0) + (b == Vote::Unknown ? 1 : 0);
      CHECK(vote_count(dynamic, unknown, 1) == vote_or(a, b));
      CHECK(vote_count(dynamic, unknown, 2) == vote_and(a, b));
    }
}

TEST_CASE("an object is what enough of its votes say, and unknown without enough") {
  for (int dynamic = 0; dynamic <= 6; ++dynamic)
    for (int fixed = 0; fixed <= 6; ++fixed)
      for (const int min_count : {1, 2, 4}) {
        const Vote vote = vote_object(dynamic, fixed, min_count, 0.5);
        const bool moves = dynamic >= min_count && dynamic >= fixed;
        CHECK(vote == (moves ? Vote::Dynamic : dynamic + fixed >= min_count ? Vote::Static : Vote::Unknown));
      }
  CHECK(vote_object(1, 1000, 1, 0) == Vote::Dynamic);  // one is enough
  CHECK(vote_object(0, 1000, 1, 0) == Vote::Static);   // but at least one is required
  CHECK(vote_object(0, 0, 1, 0) == Vote::Unknown);
  CHECK(vote_object(2, 8, 1, 0.2) == Vote::Dynamic);
  CHECK(vote_object(2, 9, 1, 0.2) == Vote::Static);
}

}  // namespace judgement_test
