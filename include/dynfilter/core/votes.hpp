// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <dynfilter/core/span.hpp>
#include <string>
#include <type_traits>
#include <vector>

namespace dynfilter {

/// Vote of a filter on one feature.
/// Unknown means that the filter cannot decide: no depth, no match or a degenerate model.
enum class Vote : std::uint8_t { Unknown, Static, Dynamic };

constexpr const char* to_string(Vote vote) {
  return vote == Vote::Static ? "static" : vote == Vote::Dynamic ? "dynamic" : "unknown";
}

/// One vote per feature with a suspicion in [0, 1]. 0 is certainly static, 1 certainly dynamic, 0.5
/// undecided. The floor restores the least suspicious features first. A prior suspect is excluded from model
/// fitting and judged more strictly, but it is not voted dynamic for that reason.
class Votes {
 public:
  static constexpr float kNoIdea = 0.5F;

  /// Resizes to n features, all Unknown.
  void reset(std::size_t n) {
    vote_.assign(n, Vote::Unknown);
    suspicion_.assign(n, kNoIdea);
    prior_.assign(n, 0);
    note_.clear();
    doubts_ = false;
  }
  /// Sets the vote on feature i. The suspicion is clipped to [0, 1], NaN is kNoIdea.
  void cast(std::size_t i, Vote vote, float suspicion) {
    vote_[i] = vote;
    suspicion_[i] = suspicion >= 0 ? std::min(suspicion, 1.0F) : suspicion < 0 ? 0.0F : kNoIdea;
  }
  /// The same with the suspicion that belongs to the vote: 1, 0 or kNoIdea.
  void cast(std::size_t i, Vote vote) {
    cast(i, vote, vote == Vote::Dynamic ? 1.0F : vote == Vote::Static ? 0.0F : kNoIdea);
  }
  void mark_prior(std::size_t i) { prior_[i] = 1; }  ///< marks feature i as a prior suspect
  /// Text for the stage's report, e.g. which model was used or why the filter abstained.
  /// The parts are texts and integers: note("motion: ", 5, " of ", 7).
  template <class... Parts>
  void note(const Parts&... parts) {
    if (!note_.empty()) note_ += "; ";
    (add(parts), ...);
  }
  const std::string& notes() const { return note_; }  ///< what note() was given, joined by "; "
  /// All inputs are there and nothing can be said: a filter that sees less need not be asked.
  void doubt() { doubts_ = true; }
  bool doubts() const { return doubts_; }  ///< whether doubt() was called
  /// Marks the prior suspects of `other`, which has the same number of features.
  void add_priors(const Votes& other) {
    for (std::size_t i = 0; i < prior_.size(); ++i) prior_[i] |= other.prior_[i];
  }
  /// Sets votes to Unknown where `kept` is 0. `kept` has one entry per feature. Suspicions do not change.
  void keep_only(Span<const std::uint8_t> kept) {
    for (std::size_t i = 0; i < vote_.size(); ++i) vote_[i] = kept[i] != 0 ? vote_[i] : Vote::Unknown;
  }
  std::size_t size() const { return vote_.size(); }
  Vote operator[](std::size_t i) const { return vote_[i]; }       ///< vote on feature i
  float suspicion(std::size_t i) const { return suspicion_[i]; }  ///< suspicion of feature i, in [0, 1]
  bool prior(std::size_t i) const { return prior_[i] != 0; }      ///< whether feature i is a prior suspect
  Span<const Vote> votes() const { return vote_; }                ///< one entry per feature
  Span<const std::uint8_t> priors() const { return prior_; }  ///< 1 if the feature is a prior suspect, else 0
  /// Number of features with this vote.
  std::size_t count(Vote vote) const {
    return static_cast<std::size_t>(std::count(vote_.begin(), vote_.end(), vote));
  }
  /// Number of prior suspects.
  std::size_t count_prior() const {
    return static_cast<std::size_t>(std::count(prior_.begin(), prior_.end(), std::uint8_t{1}));
  }
  bool operator==(const Votes& o) const {
    return vote_ == o.vote_ && suspicion_ == o.suspicion_ && prior_ == o.prior_;
  }

 private:
  std::vector<Vote> vote_;
  std::vector<float> suspicion_;
  std::vector<std::uint8_t> prior_;
  template <class Part>
  void add(const Part& part) {
    if constexpr (std::is_integral_v<Part>)
      note_ += std::to_string(part);
    else
      note_ += part;
  }

  std::string note_;
  bool doubts_ = false;
};

/// Suspicion of a measured distance with respect to its limit, in the same unit:
/// 0 at no distance, 0.5 at the limit, approaching 1 beyond it.
inline float suspicion(double distance, double limit) {
  if (!(distance >= 0) || !(limit >= 0)) return Votes::kNoIdea;
  const double sum = distance + limit;
  return sum > 0 ? static_cast<float>(distance / sum) : 0.0F;
}

}  // namespace dynfilter
