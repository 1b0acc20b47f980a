// SPDX-License-Identifier: MIT
#pragma once

#include <dynfilter/config/field_table.hpp>
#include <dynfilter/core/filter.hpp>
#include <dynfilter/core/needs.hpp>
#include <dynfilter/core/votes.hpp>
#include <dynfilter/correspondence/match.hpp>
#include <dynfilter/evidence/evidence.hpp>
#include <dynfilter/geometry/epipolar_distance.hpp>
#include <dynfilter/geometry/neighbour_noise.hpp>
#include <dynfilter/geometry/two_view_model.hpp>
#include <opencv2/core/types.hpp>
#include <string>
#include <vector>

namespace dynfilter {

/// The two-view model that measures distances.
enum class EpipolarModel {
  Auto,        ///< F, H or no model, depending on what the seeds determine
  Fundamental  ///< always F, as published
};
/// Distance measure for the fundamental matrix [px].
enum class EpipolarDistance {
  Line,    ///< of the current point from its epipolar line
  Sampson  ///< first-order distance in both images
};

struct EpipolarParams {
  double max_distance_px = 1.0;
  EpipolarModel model = EpipolarModel::Auto;
  EpipolarDistance distance = EpipolarDistance::Line;
  bool measured_noise = false;
  int min_seeds = 20;
  bool keyframe = false;
  int gap_frames = 1;

  static const FieldTable<EpipolarParams>& fields();
};

/// Rejects features away from their epipolar lines
/// (RTS-SLAM sec. 3.3, eq. 1-4 and Algorithm 1, lines 3-16).
///
/// Formula:  D = |p2' F p1| / sqrt(X^2 + Y^2) > max_distance_px, (X, Y, Z) = F p1.
///           F is fitted on the seeds by RANSAC.
///           With min_seeds or fewer, F is fitted on all features if an earlier stage suspects some
///           (its DynamicFlag). Otherwise there is no model.
///           A plane, a rotation, no motion or a tiny baseline leave F undetermined.
///           The distance from H p1 then counts (see geometry/two_view.hpp).
///           The report names the model that was used.
///           With measured_noise, max_distance_px is multiplied by max(1, sigma / (1/3 px)).
///           sigma is that of the seeds' misses in this frame (geometry/neighbour_noise.hpp).
/// Needs:    correspondences; undistorted pixels, from a camera or from the host.
/// Abstains: without correspondence, without model,
///           and where static parallax and motion cannot be separated.
/// Blind to: motion along the epipolar line; everything if the model was fitted on movers.
/// State:    none; the pipeline keeps gap_frames frames.
/// Cost:     about 0.3 ms for 1000 features with 30 % outliers, with model, without flow.
class EpipolarFilter final : public NamedFilter<EpipolarFilter> {
 public:
  using Params = EpipolarParams;
  static constexpr const char* kName = "epipolar";
  static constexpr const char* kSummary = "features off their epipolar lines";

  explicit EpipolarFilter(Params params = Params());

  Needs needs() const override { return {Input::Correspondence, Input::Camera, params_.gap_frames}; }

  void apply(const Evidence& evidence, Votes& votes) override;

 private:
  /// Algorithm 1, lines 3-13. False if no model is to be fitted.
  bool collect_seeds(const Evidence& evidence, const Match& match);

  static bool has_fundamental(const TwoViewModel& model) { return model.F != Matrix9{}; }

  static void note_model(const TwoViewModel& model, Votes& votes);

  /// What max_distance_px is multiplied by in this frame, at least 1.
  double noise_factor(const Evidence& evidence, const Match& match, const TwoViewModel& model, bool by_line,
                      Votes& votes);
  static cv::Point2f across_line_px(const TwoViewModel& model, cv::Point2f then, cv::Point2f now) {
    return {static_cast<float>(epipolar_offset_px(model.F, then, now)), 0};
  }
  static cv::Point2f beside_point_px(const TwoViewModel& model, cv::Point2f then, cv::Point2f now) {
    return now - cv::Point2f(transfer(model.H, then));
  }

  void judge_by_model(const Evidence& evidence, const Match& match, const TwoViewModel& model,
                      Votes& votes) const;

  void judge_by_fundamental(const Evidence& evidence, const Match& match, const TwoViewModel& model,
                            Votes& votes) const;

  static constexpr float kNeighbours_px = 30;        ///< whose misses are compared
  static constexpr double kUsualNoise_px = 1.0 / 3;  ///< then 1 px, xi of RTS-SLAM, is three deviations

  Params params_;
  double limit_px_ = 0;  ///< of this frame
  std::vector<int> seeds_;
  std::vector<Miss> misses_;
  NeighbourNoise neighbour_noise_;
};

}  // namespace dynfilter

#ifdef DYNFILTER_HEADER_ONLY
#include <dynfilter/filters/detail/epipolar-inl.hpp>
#endif
