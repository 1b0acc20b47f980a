// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <dynfilter/core/span.hpp>
#include <vector>

namespace dynfilter {

/// What a filter says of one feature. Unknown: it cannot tell (no depth, no match, degenerate model, ...).
enum class Vote : std::uint8_t { Unknown, Static, Dynamic };

constexpr const char* to_string(Vote vote) {
  return vote == Vote::Static ? "static" : vote == Vote::Dynamic ? "dynamic" : "unknown";
}

/// One vote per feature. The score is the suspicion: 0 = surely static, 1 = surely dynamic, 0.5 = no idea; it
/// orders features where some must be restored. A prior suspect is kept out of model fitting and judged more
/// strictly, but is not voted dynamic for it.
class Votes {
 public:
  static constexpr float kNoIdea = 0.5F;

  /// N features, all Unknown.
  void reset(std::size_t n) {
    vote_.assign(n, Vote::Unknown);
    score_.assign(n, kNoIdea);
    prior_.assign(n, 0);
  }
  void cast(std::size_t i, Vote vote, float score) {
    vote_[i] = vote;
    score_[i] = score >= 0 ? std::min(score, 1.0F) : score < 0 ? 0.0F : kNoIdea;
  }
  void cast(std::size_t i, Vote vote) {
    cast(i, vote, vote == Vote::Dynamic ? 1.0F : vote == Vote::Static ? 0.0F : kNoIdea);
  }
  void mark_prior(std::size_t i) { prior_[i] = 1; }
  /// Marks what is marked in `other`, which has as many features.
  void add_priors(const Votes& other) {
    for (std::size_t i = 0; i < prior_.size(); ++i) prior_[i] |= other.prior_[i];
  }
  /// Unknown where `kept`, which has one entry per feature, is 0; it is 1 elsewhere. The score stays.
  void keep_only(Span<const std::uint8_t> kept) {
    for (std::size_t i = 0; i < vote_.size(); ++i) vote_[i] = kept[i] != 0 ? vote_[i] : Vote::Unknown;
  }

  std::size_t size() const { return vote_.size(); }
  Vote operator[](std::size_t i) const { return vote_[i]; }
  float score(std::size_t i) const { return score_[i]; }
  bool prior(std::size_t i) const { return prior_[i] != 0; }
  /// One entry per feature; a prior is 1 where it is marked, else 0.
  Span<const Vote> votes() const { return vote_; }
  Span<const std::uint8_t> priors() const { return prior_; }
  std::size_t count(Vote vote) const {
    return static_cast<std::size_t>(std::count(vote_.begin(), vote_.end(), vote));
  }
  std::size_t count_prior() const {
    return static_cast<std::size_t>(std::count(prior_.begin(), prior_.end(), std::uint8_t{1}));
  }
  bool operator==(const Votes& o) const {
    return vote_ == o.vote_ && score_ == o.score_ && prior_ == o.prior_;
  }

 private:
  std::vector<Vote> vote_;
  std::vector<float> score_;
  std::vector<std::uint8_t> prior_;
};

/// Suspicion of a measured distance against its limit: 0 at no distance, 0.5 at the limit, towards 1 beyond
/// it.
inline float suspicion(double distance, double limit) {
  if (!(distance >= 0) || !(limit >= 0)) return Votes::kNoIdea;
  const double sum = distance + limit;
  return sum > 0 ? static_cast<float>(distance / sum) : 0.0F;
}

}  // namespace dynfilter
