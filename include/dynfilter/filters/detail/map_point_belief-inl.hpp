// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/filters/map_point_belief.hpp>

#include <algorithm>
#include <cstddef>
#include <dynfilter/core/inline.hpp>
#include <dynfilter/core/portable_math.hpp>
#include <dynfilter/core/span.hpp>
#include <dynfilter/evidence/mask_lookup.hpp>
#include <dynfilter/evidence/semantic_input.hpp>
#include <iterator>
#include <utility>

namespace dynfilter {

DYNFILTER_INLINE const FieldTable<MapPointBeliefParams>& MapPointBeliefParams::fields() {
  using P = MapPointBeliefParams;
  static const FieldTable<P> table{
      real("initial", &P::initial, "", {0.001, 0.999}, "prior probability that a new map point moves"),
      real("hit", &P::hit, "", {0.5, 0.999},
           "probability that a mask is right: on it for moving points, off it for static ones"),
      real("threshold", &P::threshold, "", {0, 1}, "dynamic above this belief, static below"),
      integers("labels", &P::labels, {0, 255}, "labels that may move; empty: all except 0"),
      real("dilate_px", &P::dilate_px, "px", {0, 200},
           "distance from the mask up to which a feature counts as on it"),
      integer(
          "max_age_frames", &P::max_age_frames, "frames", {0, 100},
          "largest age of a mask; features are matched back to the frame of an older mask up to this age"),
      integer("forget_frames", &P::forget_frames, "frames", {1, 1000000},
              "frames without an observation after which a map point is forgotten"),
  };
  return table;
}

DYNFILTER_INLINE MapPointBeliefFilter::MapPointBeliefFilter(Params params) : params_(std::move(params)) {
  check_parameters(params_, kName);
}

DYNFILTER_INLINE void MapPointBeliefFilter::reset() {
  beliefs_.clear();
  last_mask_.reset();
}

DYNFILTER_INLINE void MapPointBeliefFilter::apply(const Evidence& evidence, Votes& votes) {
  const FrameView& frame = evidence.frame();
  if (frame.mask) learn(evidence, *frame.mask, votes);
  const double limit = log_odds(std::clamp(params_.threshold, 1e-9, 1 - 1e-9));
  for (std::size_t i = 0; i < evidence.size(); ++i) {
    Belief* const known = recent(frame.map_point_ids[i], frame.id);
    if (known == nullptr) continue;
    known->seen = frame.id;
    const double odds = known->log_odds;
    if (std::abs(odds - limit) < 1e-9) continue;
    votes.cast(i, odds > limit ? Vote::Dynamic : Vote::Static,
               static_cast<float>(1 / (1 + portable::exp(-odds))));
  }
  forget(frame.id);
}

inline void MapPointBeliefFilter::learn(const Evidence& evidence, const MaskInput& mask, Votes& votes) {
  const std::int64_t id = mask.frame_id < 0 ? evidence.frame().id : mask.frame_id;
  if (last_mask_ == id) return;
  const LateResult late = LateResult::matched_mask(evidence, id, params_.max_age_frames, votes);
  if (!late.usable()) return;
  last_mask_ = id;
  const MaskLookup lookup(mask.labels, image_size(evidence.frame()), params_.labels);
  const double step = log_odds(params_.hit);
  for (std::size_t i = 0; i < evidence.size(); ++i) {
    const std::int64_t point = evidence.frame().map_point_ids[i];
    if (point < 0 || !late.found(i)) continue;
    recent(point, evidence.frame().id);
    Belief& belief =
        beliefs_.try_emplace(point, Belief{log_odds(params_.initial), evidence.frame().id}).first->second;
    const bool on = lookup.near(late.then_px(i), params_.dilate_px);
    belief.log_odds = std::clamp(belief.log_odds + (on ? step : -step), -kMaxLogOdds, kMaxLogOdds);
    belief.seen = evidence.frame().id;
  }
}

inline MapPointBeliefFilter::Belief* MapPointBeliefFilter::recent(std::int64_t point, std::int64_t now) {
  const auto known = beliefs_.find(point);
  if (known == beliefs_.end()) return nullptr;
  if (now - known->second.seen <= params_.forget_frames) return &known->second;
  beliefs_.erase(known);
  return nullptr;
}

inline void MapPointBeliefFilter::forget(std::int64_t now) {
  if (now % 32 != 0) return;
  for (auto it = beliefs_.begin(); it != beliefs_.end();)
    it = now - it->second.seen > params_.forget_frames ? beliefs_.erase(it) : std::next(it);
}

}  // namespace dynfilter
