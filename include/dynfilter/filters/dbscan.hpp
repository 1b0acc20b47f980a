// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <dynfilter/cluster/adaptive_dbscan.hpp>
#include <dynfilter/cluster/dbscan.hpp>
#include <dynfilter/cluster/kd_tree.hpp>
#include <dynfilter/context/context.hpp>
#include <dynfilter/core/filter.hpp>
#include <dynfilter/core/numbers.hpp>
#include <dynfilter/core/parameters.hpp>
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

  static const FieldTable<DbscanFilterParams>& fields() {
    using P = DbscanFilterParams;
    static const FieldTable<P> table{
        real("eps_m", &P::eps_m, "m", {0.001, 100}, "how near the points of an object are (Eps)"),
        integer("min_points", &P::min_points, "features", {1, 100000},
                "so many dynamic features within eps_m, itself included, make a core point (MinPts)"),
        flag("adaptive", &P::adaptive,
             "choose both from the first frame with enough dynamic features, and keep them until a reset"),
        integer("adaptive_min_points", &P::adaptive_min_points, "features", {4, 100000},
                "adaptive: so many dynamic features with depth are enough; eps_m and min_points until then"),
        real("adaptive_max_eps_m", &P::adaptive_max_eps_m, "m", {0.001, 100},
             "adaptive: a larger choice is dropped, the next frame may try"),
        integer("max_k", &P::max_k, "", {3, 200}, "adaptive: the largest k that is tried"),
    };
    return table;
  }
};

/// Features of moving objects, from those that earlier stages called dynamic (Zhou et al. sec. 3.2.2).
///
/// Formula:  DBSCAN over the 3-D points of the dynamic features. A feature within Eps of a core point belongs
/// to
///           the object and is dynamic too; noise points spread nothing.
///           adaptive: Eps_k = mean distance to the k-th neighbour, MinPts_k = mean number of points within
///           Eps_k; the third of the first three k in a row with equal cluster counts
///           (cluster/adaptive_dbscan.hpp).
/// Needs:    depth, camera. In a `sequence`, after what finds dynamic features.
/// Abstains: where nothing was called dynamic; on features without depth; never votes static.
/// Blind to: objects with fewer dynamic features than min_points. What stands within Eps of a mover goes with
///           it.
/// State:    adaptive: the parameters, until reset(). Cost: 0.1 ms for 1000 features; 2 ms where it chooses.
class DbscanFilter final : public Filter {
 public:
  using Params = DbscanFilterParams;
  static constexpr const char* kName = "dbscan";
  static constexpr const char* kSummary = "features of the objects that dynamic features cluster to";

  explicit DbscanFilter(Params params = Params())
      : params_(params), adaptive_(AdaptiveDbscanLimits{params.max_k, kMaxPoints}) {
    check_parameters(params_, kName);
  }

  std::string name() const override { return kName; }
  Needs needs() const override { return {Input::Depth | Input::Camera, Input::None, 0}; }

  void apply(Context& context, Votes& votes) override {
    collect(context);
    if (seeds_.empty()) return context.note("nothing dynamic with depth to start from");
    const DbscanParams params = parameters(context);
    dbscan_.run(seeds_, params, clusters_);
    core_.clear();
    for (std::size_t k = 0; k < seeds_.size(); ++k)
      if (clusters_.core[k] != 0) core_.push_back(seeds_[k]);
    note(context, params);
    if (core_.empty()) return;
    tree_.build(core_);
    for (std::size_t i = 0; i < context.size(); ++i) {
      if (!context.judged(i)) continue;
      const KdTree::Neighbour core = tree_.nearest_within(context.points_m()[i], params.eps_m);
      if (core.index < 0) continue;
      // From 1 at a core point to 0.5 at the edge.
      const double away = std::sqrt(static_cast<double>(core.squared_distance)) / params.eps_m;
      votes.cast(i, Vote::Dynamic, static_cast<float>(1 - 0.5 * away));
    }
  }

  void reset() override { chosen_.reset(); }

  /// What `adaptive` has chosen, if it has.
  const std::optional<DbscanParams>& chosen() const { return chosen_; }

 private:
  static constexpr int kMaxPoints = 2000;

  void collect(Context& context) {
    seeds_.clear();
    for (std::size_t i = 0; i < context.size(); ++i)
      if (context.called_dynamic(i) && detail::finite(context.points_m()[i]))
        seeds_.push_back(context.points_m()[i]);
  }

  DbscanParams parameters(Context& context) {
    if (params_.adaptive && !chosen_ &&
        seeds_.size() >= static_cast<std::size_t>(params_.adaptive_min_points))
      choose(context);
    return chosen_.value_or(DbscanParams{params_.eps_m, params_.min_points});
  }
  void choose(Context& context) {
    const AdaptiveDbscanChoice& choice = adaptive_.choose(seeds_);
    if (choice.found && choice.params.eps_m <= params_.adaptive_max_eps_m)
      chosen_ = choice.params;
    else
      context.note(choice.found ? "adaptive: the points are too far apart" : "adaptive: no stable count");
  }

  void note(Context& context, const DbscanParams& params) const {
    context.note(std::to_string(clusters_.count) + " objects of " + std::to_string(seeds_.size()) +
                 " features, eps " + fixed_text(params.eps_m, 3) + " m, min_points " +
                 std::to_string(params.min_points));
  }

  Params params_;
  std::optional<DbscanParams> chosen_;
  AdaptiveDbscan adaptive_;
  GridDbscan dbscan_;
  Clusters clusters_;
  KdTree tree_;
  std::vector<cv::Point3f> seeds_, core_;
};

}  // namespace dynfilter
