// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <dynfilter/core/span.hpp>
#include <dynfilter/core/votes.hpp>
#include <opencv2/core.hpp>
#include <opencv2/core/types.hpp>
#include <optional>
#include <utility>
#include <vector>

namespace dynfilter {

/// What the stages of a pipeline tell each other about the features of one frame.
/// Filters see it through Evidence. Only combinators and the pipeline change it.
class StageState {
  struct Flags {
    std::vector<std::uint8_t> judged, prior, seed, dynamic;
  };

 public:
  using Clock = std::chrono::steady_clock;

  /// All features are judged and are seeds, except those in no image (NaN).
  void begin(const std::vector<cv::Point2f>& pixels);

  Span<const std::uint8_t> judged() const { return flags_.judged; }
  Span<const std::uint8_t> prior() const { return flags_.prior; }
  Span<const std::uint8_t> seed() const { return flags_.seed; }
  Span<const std::uint8_t> called_dynamic() const { return flags_.dynamic; }

  void mark_prior(std::size_t i) { flags_.prior[i] = 1, flags_.seed[i] = 0; }
  /// Excludes feature i from judgement. It remains a seed.
  void excuse(std::size_t i) { flags_.judged[i] = 0; }
  /// Applies the votes of an earlier stage. Its suspects are no longer seeds.
  /// Features that it rejected are neither judged again nor used for models.
  /// The loop has no branches because its conditions are unpredictable.
  void learn(const Votes& said);
  /// Restricts judgement to the prior suspects, or to the other features.
  void keep_side(bool priors);

  /// Which semantic stages suspect a feature, whatever becomes of it in the pipeline.
  void collect_suspicions(bool collect);
  bool collects_suspicions() const { return collects_suspicions_; }
  void suspect(std::size_t i, std::uint64_t stages) { suspected_by_[i] |= stages; }
  /// Bit k: stage k of the report. 0 unless they are collected.
  std::uint64_t suspected_by(std::size_t i) const { return collects_suspicions_ ? suspected_by_[i] : 0; }

  /// The time after which no further filter starts. nullopt: never.
  void set_deadline(std::optional<Clock::time_point> deadline) {
    deadline_ = deadline;
    late_at_.reset();
    skipped_ = 0;
  }
  bool is_late() const { return deadline_ && Clock::now() > *deadline_; }
  /// Stage `k` of the report ended late, or was skipped because an earlier one did.
  void ended_late(std::size_t k) { late_at_ = late_at_.value_or(k); }
  void skipped_late() { ++skipped_; }
  /// The first stage that ended late.
  std::optional<std::size_t> late_at() const { return late_at_; }
  std::size_t late_skips() const { return skipped_; }

  /// Restores what stages told each other on destruction.
  class Scope {
   public:
    explicit Scope(StageState& state) : state_(state) { state_.save(); }
    ~Scope() { state_.restore(); }
    Scope(const Scope&) = delete;
    Scope& operator=(const Scope&) = delete;

   private:
    StageState& state_;
  };

 private:
  void save();
  void restore() { std::swap(flags_, saved_[--saves_]); }

  Flags flags_;
  std::vector<Flags> saved_;  ///< of nested scopes; those after `saves_` only keep their memory
  std::size_t saves_ = 0;
  std::optional<Clock::time_point> deadline_;
  std::optional<std::size_t> late_at_;
  std::size_t skipped_ = 0;
  bool collects_suspicions_ = false;
  std::vector<std::uint64_t> suspected_by_;
};

inline void StageState::begin(const std::vector<cv::Point2f>& pixels) {
  const std::size_t n = pixels.size();
  flags_.judged.assign(n, 1);
  flags_.prior.assign(n, 0);
  flags_.seed.assign(n, 1);
  flags_.dynamic.assign(n, 0);
  for (std::size_t i = 0; i < n; ++i)
    if (std::isnan(pixels[i].x)) flags_.judged[i] = flags_.seed[i] = 0;
  collect_suspicions(false);
}

inline void StageState::learn(const Votes& said) {
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

inline void StageState::save() {
  if (saves_ == saved_.size()) saved_.emplace_back();
  saved_[saves_++] = flags_;
}

inline void StageState::keep_side(bool priors) {
  const std::uint8_t side = priors ? 1 : 0;
  for (std::size_t i = 0; i < flags_.judged.size(); ++i)
    flags_.judged[i] &= static_cast<std::uint8_t>(flags_.prior[i] == side);
}

inline void StageState::collect_suspicions(bool collect) {
  suspected_by_.assign(collect ? flags_.judged.size() : 0, 0);
  collects_suspicions_ = collect;
}

}  // namespace dynfilter
