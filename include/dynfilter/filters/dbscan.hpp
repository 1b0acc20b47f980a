// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstddef>
#include <dynfilter/cluster/adaptive_dbscan.hpp>
#include <dynfilter/cluster/clusters.hpp>
#include <dynfilter/cluster/density_clusters.hpp>
#include <dynfilter/cluster/kd_tree.hpp>
#include <dynfilter/config/numbers.hpp>
#include <dynfilter/config/parameters.hpp>
#include <dynfilter/core/filter.hpp>
#include <dynfilter/core/needs.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/evidence/evidence.hpp>
#include <opencv2/core/types.hpp>
#include <optional>
#include <string>
#include <vector>

namespace dynfilter {

struct DbscanFilterParams {
  double eps_m = 0.15;
  int min_points = 4;
  bool adaptive = false;
  int adaptive_min_points = 20;
  double adaptive_max_eps_m = 0.5;
  int max_k = 30;

  static const FieldTable<DbscanFilterParams>& fields();
};

/// Extends the dynamic features of earlier stages to moving objects (Zhou et al. sec. 3.2.2).
///
/// Formula:  DBSCAN over the 3-D points of the dynamic features.
///           A feature within Eps of a core point belongs to the object and is dynamic.
///           Noise points do not extend.
///           adaptive: Eps_k is the mean distance to the k-th neighbour.
///           MinPts_k is the mean number of points within Eps_k.
///           The third k of the first three in a row with equal cluster counts is selected
///           (cluster/adaptive_dbscan.hpp).
/// Needs:    depth, camera. Place it in a `sequence` after stages that vote dynamic.
/// Abstains: if no feature is dynamic, and on features without depth. Never votes Static.
/// Blind to: objects with fewer dynamic features than min_points.
///           Static surfaces within Eps of a mover are rejected too.
/// State:    adaptive: the chosen parameters, until reset().
/// Cost:     0.1 ms for 1000 features; 2 ms in the frame that chooses.
class DbscanFilter final : public NamedFilter<DbscanFilter> {
 public:
  using Params = DbscanFilterParams;
  static constexpr const char* kName = "dbscan";
  static constexpr const char* kSummary =
      "features near clusters of features that earlier stages voted dynamic";

  explicit DbscanFilter(Params params = Params());

  Needs needs() const override { return {Input::Depth | Input::Camera, Input::None, 0}; }

  void apply(const Evidence& evidence, Votes& votes) override;

  void reset() override { chosen_.reset(); }

  /// The parameters chosen by `adaptive`, if any.
  const std::optional<DbscanParams>& chosen() const { return chosen_; }

 private:
  static constexpr int kMaxPoints = 2000;

  void collect(const Evidence& evidence);

  DbscanParams parameters(Votes& votes);
  void choose(Votes& votes);

  void note(const DbscanParams& params, Votes& votes) const;

  Params params_;
  std::optional<DbscanParams> chosen_;
  AdaptiveDbscan adaptive_;
  GridDbscan dbscan_;
  Clusters clusters_;
  KdTree tree_;
  std::vector<cv::Point3f> seeds_, core_;
};

inline const FieldTable<DbscanFilterParams>& DbscanFilterParams::fields() {
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

inline DbscanFilter::DbscanFilter(Params params)
    : params_(params), adaptive_(AdaptiveDbscanLimits{params.max_k, kMaxPoints}) {
  check_parameters(params_, kName);
}

inline void DbscanFilter::apply(const Evidence& evidence, Votes& votes) {
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

inline DbscanParams DbscanFilter::parameters(Votes& votes) {
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
