// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/filters/dbscan.hpp>

#include <cmath>
#include <cstddef>
#include <dynfilter/core/inline.hpp>
#include <dynfilter/config/numbers.hpp>

namespace dynfilter {

DYNFILTER_INLINE const FieldTable<DbscanFilterParams>& DbscanFilterParams::fields() {
  using P = DbscanFilterParams;
  static const FieldTable<P> table{
      real("eps_m", &P::eps_m, "m", {0.001, 100},
           "radius of the neighbourhood that must contain min_points (Eps)"),
      integer("min_points", &P::min_points, "features", {1, 100000},
              "dynamic features within eps_m that make a core point, itself included (MinPts)"),
      flag("adaptive", &P::adaptive,
           "choose eps_m and min_points from the first frame with enough dynamic features, and keep them "
           "until reset"),
      integer("adaptive_min_points", &P::adaptive_min_points, "features", {4, 100000},
              "adaptive: number of dynamic features with depth needed for the choice; until then eps_m and "
              "min_points apply"),
      real("adaptive_max_eps_m", &P::adaptive_max_eps_m, "m", {0.001, 100},
           "adaptive: largest eps_m that is accepted; after a larger choice, the next frame chooses again"),
      integer("max_k", &P::max_k, "", {3, 200}, "adaptive: largest neighbour number k that is tested"),
  };
  return table;
}

DYNFILTER_INLINE DbscanFilter::DbscanFilter(Params params)
    : params_(params), adaptive_(AdaptiveDbscanLimits{params.max_k, kMaxPoints}) {
  check_parameters(params_, kName);
}

DYNFILTER_INLINE void DbscanFilter::apply(const Evidence& evidence, Votes& votes) {
  collect(evidence);
  if (seeds_.empty()) return votes.note("no dynamic feature with depth");
  const DbscanParams params = parameters(votes);
  dbscan_.run(seeds_, params, clusters_);
  core_.clear();
  for (std::size_t k = 0; k < seeds_.size(); ++k)
    if (clusters_.core[k] != 0) core_.push_back(seeds_[k]);
  note(params, votes);
  if (core_.empty()) return;
  tree_.build(core_);
  for (std::size_t i = 0; i < evidence.size(); ++i) {
    if (!evidence.judged(i)) continue;
    const KdTree::Neighbour core = tree_.nearest_within(evidence.points_m()[i], params.eps_m);
    if (core.index < 0) continue;
    // 1 at a core point, 0.5 at distance Eps.
    const double away = std::sqrt(static_cast<double>(core.squared_distance)) / params.eps_m;
    votes.cast(i, Vote::Dynamic, static_cast<float>(1 - 0.5 * away));
  }
}

inline void DbscanFilter::collect(const Evidence& evidence) {
  seeds_.clear();
  for (std::size_t i = 0; i < evidence.size(); ++i)
    if (evidence.called_dynamic(i) && detail::finite(evidence.points_m()[i]))
      seeds_.push_back(evidence.points_m()[i]);
}

DYNFILTER_INLINE DbscanParams DbscanFilter::parameters(Votes& votes) {
  if (params_.adaptive && !chosen_ && seeds_.size() >= static_cast<std::size_t>(params_.adaptive_min_points))
    choose(votes);
  return chosen_.value_or(DbscanParams{params_.eps_m, params_.min_points});
}

inline void DbscanFilter::choose(Votes& votes) {
  const AdaptiveDbscanChoice& choice = adaptive_.choose(seeds_);
  if (choice.found && choice.params.eps_m <= params_.adaptive_max_eps_m)
    chosen_ = choice.params;
  else
    votes.note(choice.found ? "adaptive: the points are too far apart" : "adaptive: no stable count");
}

inline void DbscanFilter::note(const DbscanParams& params, Votes& votes) const {
  votes.note(clusters_.count, " objects of ", seeds_.size(), " features, eps ", fixed_text(params.eps_m, 3),
             " m, min_points ", params.min_points);
}

}  // namespace dynfilter
