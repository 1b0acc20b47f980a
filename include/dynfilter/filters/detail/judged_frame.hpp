// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <dynfilter/core/portable_math.hpp>
#include <dynfilter/evidence/evidence.hpp>
#include <dynfilter/geometry/depth_noise.hpp>
#include <dynfilter/motion/neighbour_field.hpp>
#include <opencv2/core/types.hpp>
#include <utility>
#include <vector>

namespace dynfilter::detail {

/// What background_motion judges a frame by, for the time of one call.
struct JudgedFrame {
  const Evidence& evidence;
  const Match& match;
  const FeatureTracks& tracks;
  const Camera& camera;
  DepthNoise sensor;                 ///< of the frame's depths
  bool stereo;                       ///< its depths are as noisy as their disparities
  double neighbour_px, neighbour_m;  ///< of a neighbourhood: radius, and largest difference in depth
  // Read in every loop.
  std::size_t features = evidence.size();
  const std::vector<float>& depths_m = evidence.depths_m();
  const std::vector<cv::Point3f>& points_m = evidence.points_m();

  JudgedFrame with(const Match& other) const {
    return {evidence, other, tracks, camera, sensor, stereo, neighbour_px, neighbour_m};
  }
  std::size_t size() const { return features; }
  float depth_m(std::size_t i) const { return depths_m[i]; }
  /// Difference in depth of features on one surface: a stereo camera's noise alone exceeds any fixed one.
  float reach_m(double least_m, float depth_m) const {
    if (!stereo || std::isnan(depth_m)) return static_cast<float>(least_m);
    const double noise_m = kReachSigmas * std::sqrt(2.0) * sensor.sigma_m(static_cast<double>(depth_m));
    return static_cast<float>(std::sqrt(least_m * least_m + noise_m * noise_m));
  }
  static constexpr double kReachSigmas = 3;  ///< of two depths' noise
};

/// What is known of each track, carried from frame to frame: evidence that it moves, and its mobility. This
/// probability that it moved falls slowly, because a mover that stops is not yet background.
class TrackMemory {
 public:
  static constexpr double kMobility_s = 2;                   ///< time constant of having moved
  static constexpr float kMoves = 2.94F, kUnknown = -2.94F;  ///< log-odds of 0.95; of a new track's 0.05

  void clear() {
    evidence_.clear();
    mobility_.clear();
    places_.clear();
  }
  /// Carries what is known to the tracks of this frame.
  void recall(const JudgedFrame& frame) {
    std::swap(last_mobility_, mobility_);
    const std::size_t n = frame.size();
    remembered_.assign(n, 0);
    mobility_.resize(n);
    for (std::size_t i = 0; i < n; ++i) {
      const auto from = static_cast<std::size_t>(frame.tracks.previous(i));
      const bool known = frame.tracks.previous(i) >= 0 && from < evidence_.size();
      if (known) remembered_[i] = evidence_[from];
      mobility_[i] = known ? last_mobility_[from] : mobility_around(frame, i);
    }
  }
  /// Keeps the evidence of this frame's features and their places, and leaves buffers in both. `belief`
  /// [nats]: what was judged against a background that may be the wrong one has a small `weight`, [0, 1].
  void learn(std::vector<float>& evidence, const std::vector<float>& belief, NeighbourPlaces& places,
             float weight, double elapsed_s) {
    std::swap(evidence_, evidence);
    std::swap(places_, places);
    const auto kept = static_cast<float>(portable::exp(-elapsed_s / kMobility_s));
    for (std::size_t i = 0; i < belief.size(); ++i)
      mobility_[i] = std::max(kept * mobility_[i], weight / (1 + portable::exp(-belief[i])));
    places_.lay_out(
        moved_, [&](std::size_t i) { return mobility_[i]; }, [](std::size_t) { return 1.0F; });
  }

  float evidence(std::size_t i) const { return remembered_[i]; }  ///< in the last frame [nats]
  const std::vector<float>& mobility() const { return mobility_; }

 private:
  static constexpr float kReach = 1.2F;  ///< of a neighbourhood, for features that appear

  /// A feature without a past takes that of the features around the place where it was.
  float mobility_around(const JudgedFrame& frame, std::size_t i) const {
    const Match& match = frame.match;
    const bool found = match.reference != nullptr && match.found(i);
    const float depth_m =
        found && match.has_reference_point(i) ? match.reference_points_m[i].z : frame.depth_m(i);
    const NeighbourPlaces::Sum sum = places_.around(
        moved_, found ? match.correspondences.reference_px[i] : frame.evidence.pixels()[i], depth_m,
        kReach * static_cast<float>(frame.neighbour_px), frame.reach_m(frame.neighbour_m, depth_m));
    return sum.weights > 0 ? sum.values / sum.weights : 0;
  }

  std::vector<float> evidence_, mobility_, last_mobility_;  ///< of the last frame, then of this one
  std::vector<float> remembered_;                           ///< of this frame's features
  NeighbourPlaces places_;                                  ///< of the last frame's features
  NeighbourPlaces::Field moved_;                            ///< mobility there
};

}  // namespace dynfilter::detail
