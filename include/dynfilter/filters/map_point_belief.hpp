// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <dynfilter/config/registry.hpp>
#include <dynfilter/core/portable_math.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/evidence/evidence.hpp>
#include <dynfilter/evidence/mask_lookup.hpp>
#include <dynfilter/evidence/semantic_input.hpp>
#include <iterator>
#include <optional>
#include <unordered_map>

namespace dynfilter {

struct MapPointBeliefParams {
  double initial = 0.5;
  double hit = 0.9;
  double threshold = 0.5;
  /// Distance from the mask up to which a feature counts as on it.
  static constexpr double kDilate_px = 0;
  int max_age_frames = 15;
  /// Frames without an observation after which a map point is forgotten.
  static constexpr int kForgetFrames = 300;

  static const FieldTable<MapPointBeliefParams>& fields() {
    using P = MapPointBeliefParams;
    static const FieldTable<P> table{
        real("initial", &P::initial, "", {0.001, 0.999}, "prior probability that a new map point moves"),
        real("hit", &P::hit, "", {0.5, 0.999},
             "probability that a mask is right: on it for moving points, off it for static ones"),
        real("threshold", &P::threshold, "", {0, 1}, "dynamic above this belief, static below"),
        integer(
            "max_age_frames", &P::max_age_frames, "frames", {0, 100},
            "largest age of a mask; features are matched back to the frame of an older mask up to this age"),
    };
    return table;
  }
};

/// Rejects map points that masks mark as movable more often than not (RDS-SLAM, Liu and Miura 2021).
///
/// Formula:  Bayes' rule per map point, starting at `initial`: b' = b P(z|moves) / (b P(z|moves) + (1 - b)
///           P(z|static)). The observation z is on or off the mask. P is `hit` if z agrees with the
///           hypothesis, else 1 - hit.
/// Needs:    map points, and masks at any rate. Each mask is used once, even when it arrives late. Late masks
///           need correspondences to their frame. Between masks, the last beliefs decide.
/// Abstains: on features without a map point, and at a belief of exactly `threshold`.
/// Blind to: classes that the network does not detect; whether the object moves at all.
/// State:    one belief per map point observed in the last 300 frames.
///           The pipeline keeps max_age_frames frames for late masks.
/// Cost:     about 0.1 us per feature; 10 us with a mask for 1000 features.
class MapPointBeliefFilter final : public ParametricFilter<MapPointBeliefFilter, MapPointBeliefParams> {
 public:
  using ParametricFilter::ParametricFilter;
  static constexpr const char* kName = "map_point_belief";
  static constexpr const char* kSummary =
      "map points that masks mark as movable, combined over time by Bayes' rule";

  Needs needs() const override {
    return {Input::MapPoints, Input::Mask | Input::Correspondence, params_.max_age_frames};
  }
  void reset() override {
    beliefs_.clear();
    last_mask_.reset();
  }
  void apply(const Evidence& evidence, Votes& votes) override;

 private:
  static constexpr double kMaxLogOdds = 20;  // so that later masks can still change any belief
  struct Belief {
    double log_odds = 0;
    std::int64_t seen = 0;
  };

  void learn(const Evidence& evidence, const MaskInput& mask, Votes& votes);

  /// Null: never observed, or not within kForgetFrames, also where the filter did not run meanwhile.
  Belief* recent(std::int64_t point, std::int64_t now);

  /// Runs every 32 frames, so that its cost is negligible.
  void forget(std::int64_t now) {
    if (now % 32 != 0) return;
    for (auto it = beliefs_.begin(); it != beliefs_.end();)
      it = now - it->second.seen > Params::kForgetFrames ? beliefs_.erase(it) : std::next(it);
  }

  std::unordered_map<std::int64_t, Belief> beliefs_;
  std::optional<std::int64_t> last_mask_;
};

inline void MapPointBeliefFilter::apply(const Evidence& evidence, Votes& votes) {
  const FrameView& frame = evidence.frame();
  if (frame.mask) learn(evidence, *frame.mask, votes);
  const double limit = portable::log_odds(std::clamp(params_.threshold, 1e-9, 1 - 1e-9));
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
  const MaskLookup lookup(mask.labels, image_size(evidence.frame()));
  const double step = portable::log_odds(params_.hit);
  for (std::size_t i = 0; i < evidence.size(); ++i) {
    const std::int64_t point = evidence.frame().map_point_ids[i];
    if (point < 0 || !late.found(i)) continue;
    recent(point, evidence.frame().id);
    Belief& belief =
        beliefs_.try_emplace(point, Belief{portable::log_odds(params_.initial), evidence.frame().id})
            .first->second;
    const bool on = lookup.near(late.then_px(i), Params::kDilate_px);
    belief.log_odds = std::clamp(belief.log_odds + (on ? step : -step), -kMaxLogOdds, kMaxLogOdds);
    belief.seen = evidence.frame().id;
  }
}

inline MapPointBeliefFilter::Belief* MapPointBeliefFilter::recent(std::int64_t point, std::int64_t now) {
  const auto known = beliefs_.find(point);
  if (known == beliefs_.end()) return nullptr;
  if (now - known->second.seen <= Params::kForgetFrames) return &known->second;
  beliefs_.erase(known);
  return nullptr;
}

}  // namespace dynfilter
