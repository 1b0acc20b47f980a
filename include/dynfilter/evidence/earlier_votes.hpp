// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <dynfilter/core/span.hpp>
#include <dynfilter/core/votes.hpp>
#include <opencv2/core.hpp>
#include <utility>
#include <vector>

namespace dynfilter {

/// What earlier stages of a pipeline said about the features of one frame: who is judged, suspected, a seed,
/// or called dynamic. Filters read it through Evidence. Only combinators and the pipeline change it.
class EarlierVotes {
  struct Flags {
    std::vector<std::uint8_t> judged, prior, seed, dynamic;
  };

 public:
  /// All features are judged and are seeds, except those in no image (NaN).
  void begin(const std::vector<cv::Point2f>& pixels);

  Span<const std::uint8_t> judged() const { return flags_.judged; }  ///< 1 if this stage judges the feature
  Span<const std::uint8_t> prior() const { return flags_.prior; }    ///< 1 if a semantic stage suspects it
  Span<const std::uint8_t> seed() const { return flags_.seed; }      ///< 1 if models may be fitted on it
  /// 1 if an earlier stage called it dynamic.
  Span<const std::uint8_t> called_dynamic() const { return flags_.dynamic; }

  /// Suspects feature i, which is then no seed.
  void mark_prior(std::size_t i) { flags_.prior[i] = 1, flags_.seed[i] = 0; }
  /// Excludes feature i from judgement. It remains a seed.
  void exclude(std::size_t i) { flags_.judged[i] = 0; }
  /// Applies the votes of an earlier stage. Its suspects are no longer seeds.
  /// Features that it rejected are neither judged again nor used for models.
  /// The loop has no branches because its conditions are unpredictable.
  void learn(const Votes& said);
  /// Restricts judgement to the prior suspects, or to the other features.
  void keep_side(bool priors);

  /// Restores what stages told each other on destruction.
  class Scope {
   public:
    explicit Scope(EarlierVotes& votes) : votes_(votes) { votes_.save(); }  ///< saves the present state
    ~Scope() { votes_.restore(); }
    Scope(const Scope&) = delete;
    Scope& operator=(const Scope&) = delete;

   private:
    EarlierVotes& votes_;
  };

 private:
  void save();
  void restore() { std::swap(flags_, saved_[--saves_]); }

  Flags flags_;
  std::vector<Flags> saved_;  ///< of nested scopes; those after `saves_` only keep their memory
  std::size_t saves_ = 0;
};

inline void EarlierVotes::begin(const std::vector<cv::Point2f>& pixels) {
  const std::size_t n = pixels.size();
  flags_.judged.assign(n, 1);
  flags_.prior.assign(n, 0);
  flags_.seed.assign(n, 1);
  flags_.dynamic.assign(n, 0);
  for (std::size_t i = 0; i < n; ++i)
    if (std::isnan(pixels[i].x)) flags_.judged[i] = flags_.seed[i] = 0;
}

inline void EarlierVotes::learn(const Votes& said) {
  const Vote* vote = said.votes().data();
  const std::uint8_t* suspect = said.priors().data();
  std::uint8_t *judged = flags_.judged.data(), *prior = flags_.prior.data(), *seed = flags_.seed.data(),
               *dynamic = flags_.dynamic.data();
  for (std::size_t i = 0; i < flags_.judged.size(); ++i) {
    const auto rejected = static_cast<std::uint8_t>(vote[i] == Vote::Dynamic);
    prior[i] |= suspect[i];
    dynamic[i] |= rejected;
    judged[i] &= rejected ^ 1;
    seed[i] &= (rejected | suspect[i]) ^ 1;
  }
}

inline void EarlierVotes::save() {
  if (saves_ == saved_.size()) saved_.emplace_back();
  saved_[saves_++] = flags_;
}

inline void EarlierVotes::keep_side(bool priors) {
  const std::uint8_t side = priors ? 1 : 0;
  for (std::size_t i = 0; i < flags_.judged.size(); ++i)
    flags_.judged[i] &= static_cast<std::uint8_t>(flags_.prior[i] == side);
}

}  // namespace dynfilter
