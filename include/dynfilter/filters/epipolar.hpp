// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <dynfilter/config/registry.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/evidence/evidence.hpp>
#include <dynfilter/geometry/epipolar_distance.hpp>
#include <dynfilter/geometry/neighbour_noise.hpp>
#include <dynfilter/geometry/two_view_model.hpp>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

namespace dynfilter {

/// The two-view model that measures distances.
enum class EpipolarModel {
  Auto,        ///< F, H or no model, depending on what the seeds determine
  Fundamental  ///< always F, as published
};

struct EpipolarParams {
  double max_distance_px = 1.0;
  EpipolarModel model = EpipolarModel::Auto;
  bool measured_noise = false;
  int min_seeds = 20;
  int gap_frames = 1;

  static const FieldTable<EpipolarParams>& fields() {
    using P = EpipolarParams;
    static const FieldTable<P> table{
        real("max_distance_px", &P::max_distance_px, "px", {0, 1000},
             "largest distance of a static feature (xi of RTS-SLAM)"),
        choice("model", &P::model,
               {{"auto", EpipolarModel::Auto}, {"fundamental", EpipolarModel::Fundamental}},
               "auto selects F, H or no model from the seeds; fundamental always uses F, as published"),
        flag("measured_noise", &P::measured_noise,
             "raises max_distance_px in frames whose matches have more than 1/3 px of noise, in proportion "
             "to it"),
        integer(
            "min_seeds", &P::min_seeds, "features", {7, 100000},
            "with this many seeds or fewer, and with suspects, the model is fitted on all features (N_th)"),
        integer("gap_frames", &P::gap_frames, "frames", {1, 30}, "number of frames back"),
    };
    return table;
  }
};

/// Rejects features away from their epipolar lines (RTS-SLAM sec. 3.3, eq. 1-4 and Algorithm 1, lines 3-16).
///
/// Formula:  D = |p2' F p1| / sqrt(X^2 + Y^2) > max_distance_px, (X, Y, Z) = F p1. F is fitted on the seeds
///           by RANSAC. With min_seeds or fewer, F is fitted on all features if an earlier stage suspects
///           some (its DynamicFlag). Otherwise there is no model. A plane, a rotation, no motion or a tiny
///           baseline leave F undetermined. The distance from H p1 then counts (see geometry/two_view.hpp).
///           The report names the model that was used. With measured_noise, max_distance_px is multiplied by
///           max(1, sigma / (1/3 px)). sigma is that of the seeds' misses in this frame
///           (geometry/neighbour_noise.hpp). Where the match slides along an edge, sigma is larger in that
///           direction.
/// Needs:    correspondences; undistorted pixels, from a camera or from the host.
/// Abstains: without correspondence, without model, and where static parallax and motion cannot be separated.
/// Blind to: motion along the epipolar line; everything if the model was fitted on movers.
/// State:    none; the pipeline keeps gap_frames frames.
/// Cost:     about 0.3 ms for 1000 features with 30 % outliers, with model, without flow.
class EpipolarFilter final : public ParametricFilter<EpipolarFilter, EpipolarParams> {
 public:
  using ParametricFilter::ParametricFilter;
  static constexpr const char* kName = "epipolar";
  static constexpr const char* kSummary = "features off their epipolar lines";

  Needs needs() const override { return {Input::Correspondence, Input::Camera, params_.gap_frames}; }

  void apply(const Evidence& evidence, Votes& votes) override;

 private:
  /// Algorithm 1, lines 3-13. False if no model is to be fitted.
  bool collect_seeds(const Evidence& evidence, const Match& match);

  static bool has_fundamental(const TwoViewModel& model) { return model.F != Matrix9{}; }

  static void note_model(const TwoViewModel& model, Votes& votes) {
    votes.note("model: ", to_string(model.kind), " (", to_string(model.reason), "), ", model.inliers, " of ",
               model.seeds, " seeds");
  }

  /// What max_distance_px is multiplied by in this frame, at least 1.
  double noise_factor(const Evidence& evidence, const Match& match, const TwoViewModel& model, bool by_line,
                      Votes& votes);
  static cv::Point2f across_line_px(const TwoViewModel& model, cv::Point2f then, cv::Point2f now) {
    return {static_cast<float>(epipolar_offset_px(model.F, then, now)), 0};
  }
  static cv::Point2f beside_point_px(const TwoViewModel& model, cv::Point2f then, cv::Point2f now) {
    return now - cv::Point2f(transfer(model.H, then));
  }

  /// With measured_noise, for a match that slides along an edge: by the noise in the direction of the miss.
  double limit_px(const TwoViewModel& model, bool by_line, const MatchSpread& spread, cv::Point2f then,
                  cv::Point2f now) const;

  void judge_by_model(const Evidence& evidence, const Match& match, const TwoViewModel& model,
                      Votes& votes) const;

  void judge_by_fundamental(const Evidence& evidence, const Match& match, const TwoViewModel& model,
                            Votes& votes) const;

  static constexpr float kNeighbours_px = 30;        ///< whose misses are compared
  static constexpr double kUsualNoise_px = 1.0 / 3;  ///< then 1 px, xi of RTS-SLAM, is three deviations

  double limit_px_ = 0;  ///< of this frame
  std::vector<int> seeds_;
  std::vector<Miss> misses_;
  NeighbourNoise neighbour_noise_;
};

inline void EpipolarFilter::apply(const Evidence& evidence, Votes& votes) {
  const Match& match = evidence.match({false, params_.gap_frames});
  if (match.reference == nullptr) return votes.note("no earlier frame");
  if (!collect_seeds(evidence, match)) return votes.note("model: none, too few seeds");
  const TwoViewModel& model = evidence.two_view(match, seeds_);
  note_model(model, votes);
  const bool by_model = params_.model == EpipolarModel::Auto;
  const bool by_line = !by_model || model.kind == TwoViewKind::Fundamental;
  limit_px_ = params_.max_distance_px;
  if (params_.measured_noise && evidence.count_judged() > 0)
    limit_px_ *= noise_factor(evidence, match, model, by_line, votes);
  if (by_model)
    judge_by_model(evidence, match, model, votes);
  else if (has_fundamental(model))
    judge_by_fundamental(evidence, match, model, votes);
}

inline bool EpipolarFilter::collect_seeds(const Evidence& evidence, const Match& match) {
  evidence.collect_seeds(match, false, seeds_);
  if (static_cast<int>(seeds_.size()) > params_.min_seeds) return true;
  if (!evidence.any_prior()) return false;
  evidence.collect_seeds(match, true, seeds_);
  return static_cast<int>(seeds_.size()) > params_.min_seeds;
}

inline double EpipolarFilter::noise_factor(const Evidence& evidence, const Match& match,
                                           const TwoViewModel& model, bool by_line, Votes& votes) {
  misses_.clear();
  for (const int seed : seeds_) {
    const auto i = static_cast<std::size_t>(seed);
    const cv::Point2f &then = match.reference_undistorted_px[i], &now = evidence.undistorted_pixels()[i];
    const cv::Point2f miss_px =
        by_line ? across_line_px(model, then, now) : beside_point_px(model, then, now);
    if (std::isfinite(miss_px.x + miss_px.y)) misses_.push_back({evidence.pixels()[i], 1, miss_px, 1});
  }
  const std::optional<double> noise_px =
      neighbour_noise_.whole_scale(misses_, kNeighbours_px, by_line ? MissAxes::One : MissAxes::Two);
  if (!noise_px) votes.note("noise: not measured, too few neighbours");
  return std::max(1.0, noise_px.value_or(0) / kUsualNoise_px);
}

inline double EpipolarFilter::limit_px(const TwoViewModel& model, bool by_line, const MatchSpread& spread,
                                       cv::Point2f then, cv::Point2f now) const {
  if (!params_.measured_noise || !spread.slides()) return limit_px_;
  const auto terms = detail::epipolar_terms(model.F, then, now);
  const cv::Point2d miss =
      by_line ? cv::Point2d(terms.X, terms.Y) : cv::Point2d(beside_point_px(model, then, now));
  const double length2 = miss.dot(miss), along = miss.dot(cv::Point2d(spread.edge));
  if (!(length2 > 0)) return limit_px_;
  return limit_px_ * std::sqrt(spread.across + (spread.along - spread.across) * along * along / length2);
}

inline void EpipolarFilter::judge_by_model(const Evidence& evidence, const Match& match,
                                           const TwoViewModel& model, Votes& votes) const {
  for (std::size_t i = 0; i < evidence.size(); ++i) {
    if (!evidence.judged(i) || !match.found(i)) continue;
    const cv::Point2f &then = match.reference_undistorted_px[i], &now = evidence.undistorted_pixels()[i];
    const bool by_line = model.kind == TwoViewKind::Fundamental;
    const double most_px = limit_px(model, by_line, match.correspondences.spread[i], then, now);
    const TwoViewVerdict verdict = judge(model, then, now, most_px);
    if (verdict == TwoViewVerdict::CannotSay) continue;
    votes.cast(i, verdict == TwoViewVerdict::Inconsistent ? Vote::Dynamic : Vote::Static,
               suspicion(distance_px(model, then, now), most_px));
  }
}

inline void EpipolarFilter::judge_by_fundamental(const Evidence& evidence, const Match& match,
                                                 const TwoViewModel& model, Votes& votes) const {
  for (std::size_t i = 0; i < evidence.size(); ++i) {
    if (!evidence.judged(i) || !match.found(i)) continue;
    const cv::Point2f &then = match.reference_undistorted_px[i], &now = evidence.undistorted_pixels()[i];
    const double d = epipolar_distance_px(model.F, then, now);
    if (std::isnan(d)) continue;
    const double most_px = limit_px(model, true, match.correspondences.spread[i], then, now);
    votes.cast(i, d > most_px ? Vote::Dynamic : Vote::Static, suspicion(d, most_px));
  }
}

}  // namespace dynfilter
