// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/evidence/stage_state.hpp>

#include <cmath>
#include <dynfilter/core/inline.hpp>
#include <opencv2/core.hpp>

namespace dynfilter {

DYNFILTER_INLINE void StageState::begin(const std::vector<cv::Point2f>& pixels) {
  const std::size_t n = pixels.size();
  flags_.judged.assign(n, 1);
  flags_.prior.assign(n, 0);
  flags_.seed.assign(n, 1);
  flags_.dynamic.assign(n, 0);
  for (std::size_t i = 0; i < n; ++i)
    if (std::isnan(pixels[i].x)) flags_.judged[i] = flags_.seed[i] = 0;
  collect_suspicions(false);
}

DYNFILTER_INLINE void StageState::learn(const Votes& said) {
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

DYNFILTER_INLINE void StageState::save() {
  if (saves_ == saved_.size()) saved_.emplace_back();
  saved_[saves_++] = flags_;
}

DYNFILTER_INLINE void StageState::keep_side(bool priors) {
  const std::uint8_t side = priors ? 1 : 0;
  for (std::size_t i = 0; i < flags_.judged.size(); ++i)
    flags_.judged[i] &= static_cast<std::uint8_t>(flags_.prior[i] == side);
}

DYNFILTER_INLINE void StageState::collect_suspicions(bool collect) {
  suspected_by_.assign(collect ? flags_.judged.size() : 0, 0);
  collects_suspicions_ = collect;
}

}  // namespace dynfilter
