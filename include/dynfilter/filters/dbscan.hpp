// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <dynfilter/cluster/cell_grid.hpp>
#include <dynfilter/cluster/clusters.hpp>
#include <dynfilter/cluster/density_clusters.hpp>
#include <dynfilter/config/registry.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/evidence/evidence.hpp>
#include <dynfilter/filters/detail/adaptive_dbscan.hpp>
#include <opencv2/core/types.hpp>
#include <optional>
#include <vector>

namespace dynfilter {

struct DbscanFilterParams {
  double eps_m = 0.15;
  int min_points = 4;
  bool adaptive = false;
  /// Adaptive: number of dynamic features with depth needed for the choice; until then eps_m and min_points
  /// apply. Not a key: code sets it.
  int adaptive_min_points = 20;
  /// Adaptive: largest eps_m that is accepted; after a larger choice, the next frame chooses again.
  static constexpr double kAdaptiveMaxEps_m = 0.5;
  static constexpr int kMaxK = 30;  ///< Adaptive: largest neighbour number k that is tested.

  static const FieldTable<DbscanFilterParams>& fields();
};

/// Extends the dynamic features of earlier stages to moving objects (Zhou et al. sec. 3.2.2).
///
/// Formula:  DBSCAN over the 3-D points of the dynamic features. A feature within Eps of a core point belongs
///           to the object and is dynamic. Noise points do not extend. adaptive: Eps_k is the mean distance
///           to the k-th neighbour. MinPts_k is the mean number of points within Eps_k. The third k of the
///           first three in a row with equal cluster counts is selected (filters/detail/adaptive_dbscan.hpp).
/// Needs:    depth, camera. Place it in a `sequence` after stages that vote dynamic.
/// Abstains: if no feature is dynamic, and on features without depth. Never votes Static.
/// Blind to: objects with fewer dynamic features than min_points.
///           Static surfaces within Eps of a mover are rejected too.
/// State:    adaptive: the chosen parameters, until reset().
/// Cost:     0.1 ms for 1000 features; 2 ms in the frame that chooses.
class DbscanFilter final : public ParametricFilter<DbscanFilter, DbscanFilterParams> {
 public:
  using ParametricFilter::ParametricFilter;
  static constexpr const char* kName = "dbscan";
  static constexpr const char* kSummary =
      "features near clusters of features that earlier stages voted dynamic";

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

  /// Votes for judged features within eps_m of a core point.
  void extend(const Evidence& evidence, double eps_m, Votes& votes);
  /// Squared distance of a point of the grid to the nearest core point in `rows`.
  /// Infinite if none is within the radius.
  float nearest_core(std::uint32_t place, const detail::CellGrid::Rows& rows, float radius2) const;

  std::optional<DbscanParams> chosen_;
  AdaptiveDbscan adaptive_{AdaptiveDbscanLimits{Params::kMaxK, kMaxPoints}};
  GridDbscan dbscan_;
  Clusters clusters_;
  detail::CellGrid grid_;                  ///< core points, then the judged features
  std::vector<std::uint32_t> core_count_;  ///< per cell, in front of the others
  std::vector<std::uint32_t> judged_;
  std::vector<cv::Point3f> seeds_, points_;
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/filters/detail/dbscan-inl.hpp>
#endif
